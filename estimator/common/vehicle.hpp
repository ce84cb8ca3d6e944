// A car: a bicycle with mass, yaw inertia and two tyres; its wheels, and which of them are driven.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "estimator/common/source.hpp"

namespace odomd::estimator {

/// Dynamics between a steering command and the front wheels. All 0 if the angle itself is measured.
struct SteeringActuator {
  double delay_s = 0.0;
  double lag_s = 0.0;       ///< time constant of a first-order lag
  double rate_limit = 0.0;  ///< [rad/s]; 0: none
};

/// Which axle the engine drives.
enum class Driven : std::uint8_t { rear, front, all };

/// SI units. The defaults are the reference car (the paper author's published 1:10 car).
/// Stiffnesses are positive, for a whole axle; the signs are in the formulas (errata, 2).
struct Vehicle {
  double mass = 2.985;                      ///< m [kg]
  double front_axle = 0.175;                ///< l_v [m], centre of gravity to front axle
  double rear_axle = 0.085;                 ///< l_h [m], centre of gravity to rear axle
  double yaw_inertia = 0.0283384;           ///< J_z [kg m²]
  double cornering_stiffness_front = 20.0;  ///< C_v [N/rad]
  double cornering_stiffness_rear = 60.0;   ///< C_h [N/rad]
  double track_width = 0.16;                ///< [m]
  double grip_front = 0.0;  ///< peak lateral force / mass on the axle [m/s²]; 0: linear tyres
  double grip_rear = 0.0;   ///< the same for the rear axle

  SteeringActuator steering;
  Driven driven = Driven::rear;

  [[nodiscard]] constexpr double wheelbase() const { return front_axle + rear_axle; }
};

/// The speed [m/s] at which the lateral motion settles within one `dt`; at lower speeds, steps do
/// not resolve this motion. 0.185 m/s for the reference car at 5 ms.
[[nodiscard]] inline double slowest_resolved_speed(const Vehicle& car, double dt) noexcept {
  const double c_v = car.cornering_stiffness_front;
  const double c_h = car.cornering_stiffness_rear;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  return dt *
         std::max((c_v + c_h) / car.mass, (l_v * l_v * c_v + l_h * l_h * c_h) / car.yaw_inertia);
}

/// Whether a source's wheel is driven; the motor counts as a driven wheel.
[[nodiscard]] constexpr bool is_driven(Driven driven, Source source) noexcept {
  return driven == Driven::all || info_of(source).axle == Axle::driven ||
         is_front(source) == (driven == Driven::front);
}

/// Lateral speed times the tangent of the slip angle: the scale of a sliding tyre's spin [m/s]. A
/// tyre slower than a wheelbase per second counts as not sliding.
[[nodiscard]] inline double slide_of(double sideways, double along, const Vehicle& car) noexcept {
  return sideways * sideways / std::max(std::abs(along), car.wheelbase());
}

/// A wheel whose measured speed is lower may be at rest [m/s].
inline constexpr double slowest_turning = 0.01;

/// Whether a wheel that measures `speed` with the noise `sigma` turns: faster than 2 `sigma`,
/// clamped to the range from 0.01 to 0.03 m/s.
[[nodiscard]] inline bool is_turning(double speed, double sigma) noexcept {
  constexpr double surely_turning = 0.03;
  return std::abs(speed) > std::clamp(2.0 * sigma, slowest_turning, surely_turning);
}

/// A source's wheel: position ahead and left of the centre of gravity [m]; whether it is steered.
struct WheelPlace {
  double ahead = 0.0;
  double left = 0.0;
  bool steered = false;
};
[[nodiscard]] inline WheelPlace wheel_place(const Vehicle& car, Source source) noexcept {
  const double left = 0.5 * car.track_width * static_cast<double>(info_of(source).side);
  return {is_front(source) ? car.front_axle : -car.rear_axle, left, is_front(source)};
}

}  // namespace odomd::estimator
