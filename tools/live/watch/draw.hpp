// The picture of a daemon: a pure function from its state to lines, in sections. Each section is a
// title and some lines; one that has nothing to show is empty.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "tools/live/line.hpp"
#include "tools/live/watch/state.hpp"

namespace odomd::tools::watch {

struct Page {
  std::size_t columns = 80;
  std::size_t map_rows = 9;  ///< with the scale; 0: no map
  std::size_t bar_rows = 1;  ///< of a histogram; 0: the beat in one line
  Glyphs glyphs = Glyphs::unicode;
};

struct Picture {
  Lines head;  ///< who, mode, conditions: always to be seen
  Lines body;  ///< the rest, to be scrolled through where it is longer than the screen
};

[[nodiscard]] Picture draw(const State& state, const Page& page);

/// The page of a terminal: larger pictures on a larger one.
[[nodiscard]] Page page_for(std::size_t columns, std::size_t rows, Glyphs glyphs);

/// How the screen stands.
struct View {
  std::size_t columns = 80;
  std::size_t rows = 24;
  std::size_t scrolled =
      0;  ///< lines of the body above the screen; too many are the most there are
  bool paused = false;
  bool lists_keys = false;  ///< instead of the body
  Glyphs glyphs = Glyphs::unicode;
};

/// Lines of the body that the screen cannot show at once.
[[nodiscard]] std::size_t most_scrolled(const Picture& picture, const View& view);

/// Exactly `rows` lines of exactly `columns`: head, what fits of the body, and the keys.
[[nodiscard]] Lines screen(const Picture& picture, const View& view);

// Of the shared memory, the beat's percentiles of the status (segment_sections.cpp).
[[nodiscard]] Lines who_and_mode(const State& state, const Page& page);
[[nodiscard]] Lines pose_section(const State& state, const Page& page);
[[nodiscard]] Lines beat_section(const State& state, const Page& page);

// Of the status document, or why there is none (status_sections.cpp). Like all that read it, this
// throws a Json::exception where it cannot be parsed; draw() says so.
[[nodiscard]] Lines status_sections(const State& state, const Page& page);

/// "── pose ── note ──────": as wide as the page.
[[nodiscard]] Line title(std::string_view name, std::string_view note, const Page& page);

/// The one or the other, by what the terminal can show.
[[nodiscard]] std::string_view glyph(const Page& page, std::string_view unicode,
                                     std::string_view ascii);

}  // namespace odomd::tools::watch
