// Positions of the wheels, and which of them are driven.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/common/measurement.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

/// All sources for which is_wheel() is true.
inline constexpr std::array wheel_sources{Source::wheel_front_left, Source::wheel_front_right,
                                          Source::wheel_rear_left,  Source::wheel_rear_right,
                                          Source::wheel_rear,       Source::motor};

[[nodiscard]] constexpr bool is_front(Source wheel) noexcept {
  return wheel == Source::wheel_front_left || wheel == Source::wheel_front_right;
}

/// Whether a source's wheel is driven; the motor counts as a driven wheel.
[[nodiscard]] constexpr bool is_driven(Driven driven, Source source) noexcept {
  return driven == Driven::all || source == Source::motor ||
         is_front(source) == (driven == Driven::front);
}

/// A wheel with a lower measured speed may stand [m/s].
inline constexpr double slowest_turning = 0.01;

/// Whether a wheel that measures `speed` with the noise `sigma` turns: faster than twice its noise,
/// which is clamped to limits.
[[nodiscard]] inline bool is_turning(double speed, double sigma) noexcept {
  constexpr double surely_turning = 0.03;
  return std::abs(speed) > std::clamp(2.0 * sigma, slowest_turning, surely_turning);
}

/// Position of a source's wheel ahead and left of the centre of gravity [m], and if it is steered.
struct WheelPlace {
  double ahead = 0.0;
  double left = 0.0;
  bool steered = false;
};
[[nodiscard]] inline WheelPlace wheel_place(const Vehicle& car, Source source) noexcept {
  const double half_track = 0.5 * car.track_width;
  const bool left = source == Source::wheel_front_left || source == Source::wheel_rear_left;
  const bool right = source == Source::wheel_front_right || source == Source::wheel_rear_right;
  return {is_front(source) ? car.front_axle : -car.rear_axle,
          left    ? half_track
          : right ? -half_track
                  : 0.0,
          is_front(source)};
}

}  // namespace odomd::estimator
