// The picture of a daemon: a pure function from its state to lines, in sections. Each section is a
// title and some lines; a section without content is empty.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "tools/live/line.hpp"
#include "tools/live/watch/state.hpp"

namespace odomd::tools::watch {

struct Page {
  std::size_t columns = 80;
  std::size_t map_rows = 9;  ///< including the scale; 0: no map
  std::size_t bar_rows = 1;  ///< height of a histogram; 0: the beat in one line
  Glyphs glyphs = Glyphs::unicode;
};

struct Picture {
  Lines head;  ///< daemon, mode, conditions: always visible
  Lines body;  ///< the rest; can be scrolled if it is longer than the screen
};

[[nodiscard]] Picture draw(const State& state, const Page& page);

/// The page for a terminal of this size: a larger one gets larger pictures.
[[nodiscard]] Page page_for(std::size_t columns, std::size_t rows, Glyphs glyphs);

/// Size and state of the screen.
struct View {
  std::size_t columns = 80;
  std::size_t rows = 24;
  std::size_t scrolled = 0;  ///< lines of the body above the screen; limited to most_scrolled()
  bool paused = false;
  bool lists_keys = false;  ///< shows the keys instead of the body
  Glyphs glyphs = Glyphs::unicode;
};

/// Lines of the body that the screen cannot show at once.
[[nodiscard]] std::size_t most_scrolled(const Picture& picture, const View& view);

/// Exactly `rows` lines of exactly `columns`: the head, the part of the body that fits, the keys.
[[nodiscard]] Lines screen(const Picture& picture, const View& view);

// These show the shared memory; the beat's percentiles come from the status (segment_sections.cpp).
[[nodiscard]] Lines who_and_mode(const State& state, const Page& page);
[[nodiscard]] Lines pose_section(const State& state, const Page& page);
[[nodiscard]] Lines beat_section(const State& state, const Page& page);

// Shows the status document, or why there is none (status_sections.cpp). Like all readers of the
// document it throws a Json::exception for a wrong type; draw() shows that.
[[nodiscard]] Lines status_sections(const State& state, const Page& page);

/// "── pose ── note ──────", as wide as the page.
[[nodiscard]] Line title(std::string_view name, std::string_view note, const Page& page);

/// One of the two forms, depending on the characters that the terminal can show.
[[nodiscard]] std::string_view glyph(const Page& page, std::string_view unicode,
                                     std::string_view ascii);

}  // namespace odomd::tools::watch
