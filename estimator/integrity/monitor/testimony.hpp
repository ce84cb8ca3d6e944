// What every source says of the motion over the last fraction of a second, and what of it cannot be
// true together.
#pragma once

#include <array>
#include <cstddef>

#include "estimator/integrity/monitor/contradictions.hpp"
#include "estimator/integrity/monitor/interval.hpp"
#include "estimator/integrity/monitor/sources.hpp"

namespace odomd::estimator::monitor {

/// What knows the speed: the wheels in the order of their sources, then the camera.
inline constexpr std::size_t seen_speed = wheel_count;
inline constexpr std::size_t speed_count = wheel_count + 1;

/// What knows how the car turns.
enum Turning : std::size_t {
  by_gyro,
  by_steering,
  by_rear_axle,
  by_front_axle,
  by_felt,
  by_camera,
  turning_count
};

/// Whose samples it is made of: of one source, or of both wheels of an axle.
[[nodiscard]] constexpr std::array<Source, 2> sources_of(Turning turning) noexcept {
  switch (turning) {
    case by_gyro:
      return {Source::yaw_rate, Source::yaw_rate};
    case by_steering:
      return {Source::steering, Source::steering};
    case by_rear_axle:
      return {Source::wheel_rear_left, Source::wheel_rear_right};
    case by_front_axle:
      return {Source::wheel_front_left, Source::wheel_front_right};
    case by_felt:
      return {Source::accel_y, Source::accel_y};
    case by_camera:
    case turning_count:
      break;
  }
  return {Source::camera, Source::camera};
}

struct Testimony {
  std::array<Interval, speed_count> speeds{};          ///< v_x by each that knows it [m/s]
  Interval speed;                                      ///< what the wheels agree on
  std::array<Interval, turning_count> turns{};         ///< ψ̇ [rad/s]; by_felt: v ψ̇ [m/s²]
  std::array<Interval, turning_count> turns_longer{};  ///< over the camera's time too
  std::array<Interval, turning_count> sides{};         ///< v ψ̇ [m/s²]
  Interval ahead_felt;                                 ///< accel_x [m/s²]
  Interval ahead_felt_shortly;                         ///< over the wheels' time
  Interval speed_rate;                                 ///< v̇_x by the wheels [m/s²]

  /// As it reads where wheels that know no sign turn backwards. Steering and the difference of two
  /// wheels are worked out with their speed and have its sign; gyro, camera and the accelerometer
  /// along x know better: theirs is turned round.
  [[nodiscard]] Testimony mirrored() const noexcept {
    Testimony other = *this;
    other.speeds[seen_speed] = speeds[seen_speed].mirrored();
    for (const Turning turning : {by_gyro, by_camera}) {
      other.turns[turning] = turns[turning].mirrored();
      other.turns_longer[turning] = turns_longer[turning].mirrored();
      other.sides[turning] = sides[turning].mirrored();
    }
    other.ahead_felt = ahead_felt.mirrored();
    other.ahead_felt_shortly = ahead_felt_shortly.mirrored();
    return other;
  }
};

struct Contradicted {
  Contradictions<speed_count> speeds;
  Contradictions<turning_count> turns;
  bool lengthwise = false;

  [[nodiscard]] int count() const noexcept {
    return static_cast<int>(speeds.count() + turns.count()) + (lengthwise ? 1 : 0);
  }
};

}  // namespace odomd::estimator::monitor
