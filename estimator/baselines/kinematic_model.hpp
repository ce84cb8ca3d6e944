// The kinematic bicycle: motion by geometry alone, no slip (the paper's eqs 1-3).
//
//   ψ̇ = v_x / (l_v + l_h) tan δ                                                           (eq. 1)
//   Ẋ = v_x cos ψ                                                                          (eq. 2)
//   Ẏ = v_x sin ψ                                                                          (eq. 3)
//
// Without slip the rear axle moves along the car, the centre of gravity does not: there
// v_y = l_h ψ̇, so that eqs 2 and 3 become eqs 8 (x_dot) and 9 with that v_y (errata, 7). As
// printed, with v_y = 0, they hold for the rear axle. v_x is the same at both.
//
// Templates over the scalar, so that the tests can differentiate them automatically.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

enum class KinematicForm : std::uint8_t {
  centre_of_gravity,  ///< v_y = l_h ψ̇
  printed,            ///< v_y = 0
};

/// Input (v_x, δ) -> velocity (v_x, v_y, ψ̇) of the centre of gravity. |δ| < π/2.
template <typename T>
[[nodiscard]] Eigen::Matrix<T, 3, 1> kinematic_velocity(const Vehicle& car, KinematicForm form,
                                                        const Eigen::Matrix<T, 2, 1>& input) {
  using std::tan;
  const T& v_x = input[0];
  // ψ̇ = v_x / (l_v + l_h) tan δ                              (eq. 1)
  const T yaw_rate = v_x / car.wheelbase() * tan(input[1]);
  // v_y = l_h ψ̇                                              (errata, 7)
  const double lever = form == KinematicForm::printed ? 0.0 : car.rear_axle;
  return {v_x, lever * yaw_rate, yaw_rate};
}

/// ∂(v_x, v_y, ψ̇) / ∂(v_x, δ)
[[nodiscard]] inline Eigen::Matrix<double, 3, 2> kinematic_velocity_jacobian(
    const Vehicle& car, KinematicForm form, const Eigen::Vector2d& input) {
  const double tangent = std::tan(input[1]);
  // ∂ψ̇/∂v_x = tan δ / l,  ∂ψ̇/∂δ = v_x (1 + tan² δ) / l
  const double by_speed = tangent / car.wheelbase();
  const double by_steering = input[0] * (1.0 + tangent * tangent) / car.wheelbase();
  const double lever = form == KinematicForm::printed ? 0.0 : car.rear_axle;
  Eigen::Matrix<double, 3, 2> jacobian;
  jacobian << 1.0, 0.0,  //
      lever * by_speed, lever * by_steering, by_speed, by_steering;
  return jacobian;
}

/// Pose (X, Y, ψ) and input (v_x, δ) -> (Ẋ, Ẏ, ψ̇).
template <typename T>
[[nodiscard]] Eigen::Matrix<T, 3, 1> kinematic_pose_rate(const Vehicle& car, KinematicForm form,
                                                         const Eigen::Matrix<T, 3, 1>& pose,
                                                         const Eigen::Matrix<T, 2, 1>& input) {
  using std::cos;
  using std::sin;
  const Eigen::Matrix<T, 3, 1> v = kinematic_velocity<T>(car, form, input);
  const T c = cos(pose[2]);
  const T s = sin(pose[2]);
  return {
      v[0] * c - v[1] * s,  // Ẋ = v_x cos ψ - v_y sin ψ       (eq. 8, x_dot; eq. 2 with v_y = 0)
      v[0] * s + v[1] * c,  // Ẏ = v_x sin ψ + v_y cos ψ       (eq. 9; eq. 3 with v_y = 0)
      v[2],                 // ψ̇                               (eq. 1)
  };
}

/// The derivatives of kinematic_pose_rate.
struct KinematicJacobians {
  Eigen::Matrix3d pose;               ///< ∂(Ẋ, Ẏ, ψ̇) / ∂(X, Y, ψ)
  Eigen::Matrix<double, 3, 2> input;  ///< ∂(Ẋ, Ẏ, ψ̇) / ∂(v_x, δ)
};

[[nodiscard]] inline KinematicJacobians kinematic_pose_rate_jacobians(
    const Vehicle& car, KinematicForm form, const Eigen::Vector3d& pose,
    const Eigen::Vector2d& input) {
  const Eigen::Vector3d v = kinematic_velocity<double>(car, form, input);
  const double c = std::cos(pose[2]);
  const double s = std::sin(pose[2]);
  KinematicJacobians jacobians;
  // ∂Ẋ/∂ψ = -Ẏ, ∂Ẏ/∂ψ = Ẋ
  jacobians.pose.setZero();
  jacobians.pose(0, 2) = -v[0] * s - v[1] * c;
  jacobians.pose(1, 2) = v[0] * c - v[1] * s;
  // The velocity's own Jacobian, turned by the heading.
  Eigen::Matrix3d turn;
  turn << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
  jacobians.input = turn * kinematic_velocity_jacobian(car, form, input);
  return jacobians;
}

}  // namespace odomd::estimator
