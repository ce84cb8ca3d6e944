// The page about a daemon: a pure function from its state to lines.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "tools/live/line.hpp"
#include "tools/live/watch/observer.hpp"

namespace odomd::tools::watch {

struct Picture {
  Lines head;  ///< daemon, mode, conditions: always visible
  Lines body;  ///< the rest; can be scrolled if it is longer than the screen
};

/// The parts of the head: the daemon and its mode with the conditions, or what the page waits for.
[[nodiscard]] Lines head(const State& state, std::size_t columns);
[[nodiscard]] Lines mode_lines(const State& state, std::size_t columns);

/// The pose, with a map of this height at its right if there is room; empty without a segment.
[[nodiscard]] Lines pose_section(const State& state, std::size_t columns, std::size_t map_rows);

/// The page of odom status. `before` is an earlier document of the same daemon: rates are those
/// since then, otherwise since the daemon's start. Throws a nlohmann::json::exception if a member
/// has the wrong type.
[[nodiscard]] std::string status_as_text(const Json& document, const std::optional<Json>& before);

/// The ellipse of a 2-D normal distribution at this number of standard deviations.
struct Ellipse {
  double long_half_axis = 0.0;   ///< [m]
  double short_half_axis = 0.0;  ///< [m]
  double direction = 0.0;        ///< angle of the long axis from x [rad], in (-pi/2, pi/2]
};

/// `covariance`: xx, xy, yy [m²].
[[nodiscard]] Ellipse ellipse_of(const std::array<double, 3>& covariance, double sigmas);

/// x to the right, y upwards, with equal scales. Scale and section change in steps, so that the
/// picture does not move while the car does. `rows` (2 or more) include the scale in the last one.
[[nodiscard]] Lines draw_map(const Trail& trail, const odom_pose& pose, std::size_t columns,
                             std::size_t rows);

/// Size and state of the screen.
struct View {
  std::size_t columns = 80;
  std::size_t rows = 24;
  std::size_t scrolled = 0;  ///< lines of the body above the screen; limited to most_scrolled()
  bool paused = false;
};

/// The picture for a screen; a larger one gets a larger map.
[[nodiscard]] Picture draw(const State& state, const View& view);

/// How many lines of the body do not fit on the screen.
[[nodiscard]] std::size_t most_scrolled(const Picture& picture, const View& view);

/// Exactly `rows` lines of exactly `columns`: the head, the part of the body that fits, the keys.
[[nodiscard]] Lines screen(const Picture& picture, const View& view);

}  // namespace odomd::tools::watch
