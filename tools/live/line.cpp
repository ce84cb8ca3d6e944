#include "tools/live/line.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "base/printable.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

// The first `columns` characters.
std::string_view cut(std::string_view text, std::size_t columns) {
  std::size_t at = 0;
  for (; at < text.size(); ++at) {
    const bool begins = (static_cast<unsigned char>(text[at]) & 0xC0U) != 0x80U;
    if (begins && columns-- == 0) break;
  }
  return text.substr(0, at);
}

std::string_view sequence(Style style, Colour colour) {
  struct Sequences {
    std::string_view coloured;
    std::string_view plain;
  };
  constexpr std::array<Sequences, 7> all{{{"", ""},                   // plain
                                          {"\x1b[2m", "\x1b[2m"},     // dim
                                          {"\x1b[1m", "\x1b[1m"},     // strong
                                          {"\x1b[32m", ""},           // good
                                          {"\x1b[33m", "\x1b[1m"},    // warning
                                          {"\x1b[1;31m", "\x1b[1m"},  // bad
                                          {"\x1b[36m", ""}}};         // accent
  const Sequences& found = all.at(static_cast<std::size_t>(style));
  return colour == Colour::on ? found.coloured : found.plain;
}

}  // namespace

std::size_t width(const Line& line) {
  std::size_t columns = 0;
  for (const StyledText& span : line) columns += width(span.text);
  return columns;
}

Line fitted(const Line& line, std::size_t columns) {
  Line result;
  std::size_t left = columns;
  for (const StyledText& span : line) {
    if (left == 0) break;
    const std::string_view text = cut(span.text, left);
    left -= width(text);
    result.push_back({std::string{text}, span.style});
  }
  if (left > 0) result.push_back({std::string(left, ' ')});
  return result;
}

Line justified(Line left, const Line& right, std::size_t columns) {
  const std::size_t used = width(left) + width(right);
  if (used + 2 > columns) return fitted(left, columns);
  left.push_back({std::string(columns - used, ' ')});
  left.insert(left.end(), right.begin(), right.end());
  return left;
}

Lines side_by_side(const Lines& left, const Lines& right, std::size_t columns) {
  Lines all;
  for (std::size_t row = 0; row < std::max(left.size(), right.size()); ++row) {
    Line line = row < left.size() ? left[row] : Line{};
    if (row < right.size()) {
      line = fitted(line, columns);
      line.insert(line.end(), right[row].begin(), right[row].end());
    }
    all.push_back(std::move(line));
  }
  return all;
}

std::string as_text(const Line& line) {
  std::string text;
  for (const StyledText& span : line) text += escaped(span.text);
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

std::string as_text(const Lines& lines) {
  std::string text;
  for (const Line& line : lines) text += as_text(line) + '\n';
  return text;
}

std::string as_ansi(const Line& line, Colour colour) {
  std::string text;
  for (const StyledText& span : line) {
    const std::string_view begin = sequence(span.style, colour);
    text += begin;
    text += escaped(span.text);
    if (!begin.empty()) text += "\x1b[0m";
  }
  return text;
}

}  // namespace odomd::tools
