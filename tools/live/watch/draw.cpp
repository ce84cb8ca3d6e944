#include "tools/live/watch/draw.hpp"

#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

namespace odomd::tools::watch {
namespace {

// Two columns from this width on: it holds the longest lines of both sides.
constexpr std::size_t two_columns = 156;
constexpr std::size_t left_columns = 80;
constexpr std::size_t gap = 2;

void append(Lines& lines, Lines more) {
  lines.insert(lines.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
}

Picture draw_all(const State& state, const Page& page) {
  Picture picture{who_and_mode(state, page), {}};
  const bool wide = page.columns >= two_columns;
  Page part = page;
  if (wide) part.columns = left_columns;
  picture.body = pose_section(state, part);
  append(picture.body, beat_section(state, part));
  if (wide) part.columns = page.columns - left_columns - gap;
  Lines lists = status_sections(state, part);
  if (wide)
    picture.body = side_by_side(picture.body, lists, left_columns + gap);
  else
    append(picture.body, std::move(lists));
  return picture;
}

Lines all_keys() {
  constexpr std::array keys{"  q                   end",
                            "  p, space            pause and continue",
                            "  up, down, k, j      scroll by a line",
                            "  page up, page down  scroll by half a screen",
                            "  home, end, g, G     scroll to the first and the last line",
                            "  ?                   show or hide this list"};
  Lines lines;
  for (const char* key : keys) lines.push_back({{key}});
  return lines;
}

}  // namespace

Line title(std::string_view name, std::string_view note, const Page& page) {
  const std::string_view dash = glyph(page, "─", "-");
  std::string rule;
  Line line{{std::string{dash} + std::string{dash} + ' ', Style::dim},
            {std::string{name} + ' ', Style::strong}};
  if (!note.empty()) line.push_back({' ' + std::string{note} + ' ', Style::plain});
  for (std::size_t i = width(line); i < page.columns; ++i) rule += dash;
  line.push_back({rule, Style::dim});
  return line;
}

std::string_view glyph(const Page& page, std::string_view unicode, std::string_view ascii) {
  return page.glyphs == Glyphs::unicode ? unicode : ascii;
}

Picture draw(const State& state, const Page& page) {
  try {
    return draw_all(state, page);
  } catch (const Json::exception& error) {
    State without = state;
    without.status.reset();
    without.status_problem =
        fmt::format("cannot be parsed; are odom and odomd of the same version? ({})", error.what());
    return draw_all(without, page);
  }
}

Page page_for(std::size_t columns, std::size_t rows, Glyphs glyphs) {
  Page page{.columns = columns, .glyphs = glyphs};
  if (rows >= 44) {
    page.map_rows = 15;
    page.bar_rows = 3;
  } else if (rows >= 34) {
    page.bar_rows = 2;
  } else if (rows < 30) {  // leaves room for the sources without scrolling
    page.map_rows = 0;
    page.bar_rows = 0;
  }
  return page;
}

std::size_t most_scrolled(const Picture& picture, const View& view) {
  const std::size_t around = picture.head.size() + 1;
  const std::size_t room = view.rows > around ? view.rows - around : 0;
  return picture.body.size() > room ? picture.body.size() - room : 0;
}

Lines screen(const Picture& picture, const View& view) {
  const bool unicode = view.glyphs == Glyphs::unicode;
  const std::size_t most = most_scrolled(picture, view);
  const std::size_t first = std::min(view.scrolled, most);

  Lines lines = picture.head;
  if (view.lists_keys)
    append(lines, all_keys());
  else
    lines.insert(lines.end(), picture.body.begin() + static_cast<std::ptrdiff_t>(first),
                 picture.body.end());
  lines.resize(view.rows > 0 ? view.rows - 1 : 0);

  Line keys{{" q ", Style::strong}, {"quit  "}, {"p ", Style::strong}};
  if (view.paused) {
    keys.push_back({"continue  "});
    keys.push_back({"PAUSED  ", Style::warning});
  } else {
    keys.push_back({"pause  "});
  }
  keys.insert(keys.end(), {{"? ", Style::strong}, {"keys  "}});
  Line more;
  if (most > 0) {
    keys.push_back({unicode ? "↑↓ " : "up down ", Style::strong});
    keys.push_back({"scroll"});
    const std::size_t below = most - first;
    more = {{below > 0 ? std::to_string(below) + " more lines below " : "the end ", Style::dim}};
  }
  if (view.rows > 0) lines.push_back(justified(keys, more, view.columns));
  for (Line& line : lines) line = fitted(line, view.columns);
  return lines;
}

}  // namespace odomd::tools::watch
