// A map in braille dots: the trail, the car and its uncertainty.
#pragma once

#include <array>
#include <cstddef>

#include <odom/types.h>

#include "tools/live/line.hpp"
#include "tools/live/watch/state.hpp"

namespace odomd::tools::watch {

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

}  // namespace odomd::tools::watch
