// A little map: the trail, the car and its uncertainty in braille dots.
#pragma once

#include <array>
#include <cstddef>

#include "tools/live/watch/line.hpp"
#include "tools/live/watch/trail.hpp"

namespace odomd::watch {

/// The ellipse of a 2-D normal distribution at so many standard deviations.
struct Ellipse {
  double long_half_axis = 0.0;   ///< [m]
  double short_half_axis = 0.0;  ///< [m]
  double direction = 0.0;        ///< of the long axis, from x [rad], in (-pi/2, pi/2]
};

/// `covariance`: xx, xy, yy [m²].
[[nodiscard]] Ellipse ellipse_of(const std::array<double, 3>& covariance, double sigmas);

struct MapView {
  std::size_t columns = 0;
  std::size_t rows = 0;  ///< the last one is the scale
  Glyphs glyphs = Glyphs::unicode;
};

/// x to the right, y upwards, axes of one scale. Scale and section change in steps, so that the
/// picture stands still while the car moves.
[[nodiscard]] Lines draw_map(const Trail& trail, const odom_pose& pose, const MapView& view);

}  // namespace odomd::watch
