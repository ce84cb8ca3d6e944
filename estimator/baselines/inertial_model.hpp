// The slip odometer's velocity: the gyro turns the car, the wheels drive it, and the rear axle
// slips sideways as in a steady turn.
//
//   α_h = -(v_y - l_h ψ̇) / |v_x|                                              (eq. 7; errata, 5)
//   F_sh = C_h α_h                                                             (eq. 5, Fsh)
//   F_sh = (l_v / l) m v_x ψ̇                              (eq. 27, cornering_stiffness_rear)
//
// The last is what the rear axle bears of the centripetal force m v_x ψ̇ while ψ̈ = 0 (eqs 11 and 12
// with v̇_y = 0 and cos δ = 1). Solved for v_y:
//
//   v_y = l_h ψ̇ - v_x |v_x| ψ̇ l_v m / (l C_h)
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "estimator/common/pose.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

/// l_v m / (l C_h) [s²/m]: what the slip angle of the rear axle grows by per lateral acceleration.
[[nodiscard]] inline double rear_slip_gradient(const Vehicle& car) noexcept {
  return car.front_axle * car.mass / (car.wheelbase() * car.cornering_stiffness_rear);
}

/// Of the centre of gravity, in either direction.
[[nodiscard]] inline BodyVelocity inertial_velocity(const Vehicle& car, double v_x,
                                                    double yaw_rate) noexcept {
  // v_y = l_h ψ̇ - v_x |v_x| ψ̇ l_v m / (l C_h)         (eqs 5, 7 and 27; errata, 5)
  const double slip = v_x * std::abs(v_x) * yaw_rate * rear_slip_gradient(car);
  return {v_x, car.rear_axle * yaw_rate - slip, yaw_rate};
}

/// ∂(v_x, v_y, ψ̇) / ∂(v_x, ψ̇)
[[nodiscard]] inline Eigen::Matrix<double, 3, 2> inertial_velocity_jacobian(
    const Vehicle& car, double v_x, double yaw_rate) noexcept {
  const double gradient = rear_slip_gradient(car);
  Eigen::Matrix<double, 3, 2> j;
  // ∂(v_x |v_x|)/∂v_x = 2 |v_x|
  j << 1.0, 0.0,  //
      -2.0 * std::abs(v_x) * yaw_rate * gradient,
      car.rear_axle - v_x * std::abs(v_x) * gradient,  //
      0.0, 1.0;
  return j;
}

}  // namespace odomd::estimator
