// The parts of the picture. Each is a title and some lines; a part that has nothing to show is
// empty.
#pragma once

#include <string>
#include <string_view>

#include "tools/live/status_values.hpp"
#include "tools/live/watch/draw.hpp"

namespace odomd::watch {

// Of the shared memory (pose_section.cpp).
[[nodiscard]] Lines who_and_mode(const State& state, const Page& page);
[[nodiscard]] Lines pose_section(const State& state, const Page& page);

// Of both (beat_section.cpp).
[[nodiscard]] Lines beat_section(const State& state, const Page& page);

// Of the status document (status_sections.cpp); these throw a nlohmann::json::exception where it is
// not understood.
[[nodiscard]] Lines source_section(const State& state, const Page& page);
[[nodiscard]] Lines calibration_section(const State& state, const Page& page);
[[nodiscard]] Lines camera_section(const State& state, const Page& page);
[[nodiscard]] Lines message_section(const State& state, const Page& page);
[[nodiscard]] Lines bus_section(const State& state, const Page& page);

/// "── pose ── note ──────": as wide as the page.
[[nodiscard]] Line title(std::string_view name, std::string_view note, const Page& page);

/// The one or the other, by what the terminal can show.
[[nodiscard]] std::string_view glyph(const Page& page, std::string_view unicode,
                                     std::string_view ascii);

}  // namespace odomd::watch
