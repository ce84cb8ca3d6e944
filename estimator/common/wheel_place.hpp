// Places of the wheels, and which of them are driven.
#pragma once

#include <array>

#include "estimator/common/measurement.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

/// All sources of wheel speeds: is_wheel().
inline constexpr std::array wheel_sources{Source::wheel_front_left, Source::wheel_front_right,
                                          Source::wheel_rear_left,  Source::wheel_rear_right,
                                          Source::wheel_rear,       Source::motor};

/// Whether a source's wheel is driven; the motor counts as one.
[[nodiscard]] constexpr bool is_driven(Driven driven, Source source) noexcept {
  const bool front = source == Source::wheel_front_left || source == Source::wheel_front_right;
  return driven == Driven::all || source == Source::motor || front == (driven == Driven::front);
}

/// Place of a source's wheel: ahead and left of the centre of gravity [m]; steered or not.
struct WheelPlace {
  double ahead = 0.0;
  double left = 0.0;
  bool steered = false;
};
[[nodiscard]] inline WheelPlace wheel_place(const Vehicle& car, Source source) noexcept {
  const double half_track = 0.5 * car.track_width;
  switch (source) {
    case Source::wheel_front_left:
      return {car.front_axle, half_track, true};
    case Source::wheel_front_right:
      return {car.front_axle, -half_track, true};
    case Source::wheel_rear_left:
      return {-car.rear_axle, half_track, false};
    case Source::wheel_rear_right:
      return {-car.rear_axle, -half_track, false};
    default:  // the rear axle, the motor
      return {-car.rear_axle, 0.0, false};
  }
}

}  // namespace odomd::estimator
