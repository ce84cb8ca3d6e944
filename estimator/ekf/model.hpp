// The motion of the full filter: the reversible discrete bicycle (errata, 5) on the forces of two
// tyres, the front one with an unknown part, driven by the accelerometer; the pose by the mean
// velocity of the step; Jacobian and process noise. Derived in docs/model.md, "The full filter".
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>

#include "estimator/common/vehicle.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Process noise: densities, so that any step gives the same filter (errata, 6).
struct Noise {
  double v_x = 0.03;               ///< with an accelerometer [m/s/√s]
  double v_x_per_accel = 0.1;      ///< on top of it, per acceleration felt [√s]
  double v_x_alone = 1.5;          ///< without one: how a driver brakes and speeds up [m/s/√s]
  double v_y = 0.05;               ///< [m/s/√s]
  double yaw_rate = 0.03;          ///< [rad/s/√s]
  double position = 5e-4;          ///< [m/√s]
  double yaw = 2e-4;               ///< [rad/√s]
  double front_force = 1.0;        ///< standard deviation of e [m/s²] ...
  double front_force_s = 2.0;      ///< ... and its correlation time [s]
  double yaw_moment = 7.0;         ///< standard deviation of e_M [rad/s²] ...
  double yaw_moment_s = 0.3;       ///< ... and its correlation time [s]
  double front_force_alone = 6.0;  ///< the same without steering [m/s²]

  double gyro_bias = 6e-5;  ///< walks, in the state's unit per √s
  double gyro_scale = 2e-5;
  double accel_bias = 3e-3;
  double wheel_scale = 1e-4;
  double steering_offset = 1e-4;
  double stiffness_scale = 5e-3;
};

/// What is known of the car beside the state, for one step.
struct Input {
  double steering = 0.0;  ///< δ as measured [rad]
  double accel_x = 0.0;   ///< as measured [m/s²]
  bool has_steering = false;
  bool has_accel_x = false;
  /// What the noise of its samples, each held until the next, makes of v_x [m/s/√s].
  double accel_x_density = 0.0;
};

/// Parameters of the motion that do not change.
struct CarModel {
  Vehicle car;
  std::array<double, 2> imu_position{};  ///< (p_x, p_y), from the centre of gravity [m]
  Noise noise;
};

/// [v_x, v_y, ψ̇] after `dt`. `s` are the states v_x ... stiffness_scale, in their order.
///
///   v_x,k = v_x + Δt (a_x - b_ax + ψ̇² p_x + v_y ψ̇)                          (errata, 4)
///   v_y,k, ψ̇_k: eqs 32 and 33 with |v_x| where v_x stands for inertia (errata, 1, 2 and 5), with
///   C (1 + κ) for C, δ - δ_0 for δ, and e at the front axle: Δt m |v_x| e beside -b,
///   Δt m l_v |v_x| e beside -d, and Δt J_z |v_x| e_M there
template <typename T>
[[nodiscard]] Eigen::Matrix<T, 3, 1> next_velocity(const CarModel& model, const Input& input,
                                                   const Eigen::Matrix<T, 8, 1>& s, double dt) {
  using std::abs;
  const Vehicle& car = model.car;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  const T& v_x = s[0];
  const T& v_y = s[1];
  const T& yaw_rate = s[2];
  const T& e = s[3];
  const T w = abs(v_x);
  const T k = 1.0 + s[7];
  const T c_v = car.cornering_stiffness_front * k;
  const T c_h = car.cornering_stiffness_rear * k;
  const T delta =
      input.has_steering ? static_cast<T>(input.steering - s[6]) : static_cast<T>(0.0 * s[6]);
  const double m = car.mass;
  const double j_z = car.yaw_inertia;

  const T a_x =
      input.has_accel_x
          ? static_cast<T>(input.accel_x - s[5] + yaw_rate * yaw_rate * model.imu_position[0])
          : static_cast<T>(0.0 * s[5]);
  const T coupling = dt * (l_v * c_v - l_h * c_h);
  const T steer = dt * c_v * delta * v_x;
  const T push = dt * m * w * e;
  const T turn = dt * j_z * w * s[4];
  return {
      v_x + dt * (a_x + v_y * yaw_rate),
      (m * w * v_y - coupling * yaw_rate + steer - dt * m * v_x * w * yaw_rate + push) /
          (m * w + dt * (c_v + c_h)),
      (j_z * w * yaw_rate - coupling * v_y + l_v * (steer + push) + turn) /
          (j_z * w + dt * (l_v * l_v * c_v + l_h * l_h * c_h)),
  };
}

/// next_velocity() at a state, with its Jacobian by the states v_x ... stiffness_scale.
struct VelocityStep {
  Eigen::Vector3d velocity;
  Eigen::Matrix<double, 3, 8> by;
};
[[nodiscard]] VelocityStep velocity_linearised(const CarModel& model, const Input& input,
                                               const Vector& state, double dt) noexcept;

/// The pose after `dt` at the mean of the velocities at both ends, heading in the middle:
///   X' = X + Δt (v̄_x cos ψ_m - v̄_y sin ψ_m),  Y' = Y + Δt (v̄_x sin ψ_m + v̄_y cos ψ_m),
///   ψ' = ψ + Δt ψ̇_m,  ψ_m = ψ + Δt ψ̇_m / 2                                 (eqs 8 and 9)
template <typename T>
[[nodiscard]] Eigen::Matrix<T, 3, 1> next_pose(const Eigen::Matrix<T, 3, 1>& pose,
                                               const Eigen::Matrix<T, 3, 1>& from,
                                               const Eigen::Matrix<T, 3, 1>& to, double dt) {
  using std::cos;
  using std::sin;
  const Eigen::Matrix<T, 3, 1> mean = 0.5 * (from + to);
  const T middle = pose[2] + (0.5 * dt) * mean[2];
  const T c = cos(middle);
  const T s = sin(middle);
  return {pose[0] + dt * (mean[0] * c - mean[1] * s), pose[1] + dt * (mean[0] * s + mean[1] * c),
          pose[2] + dt * mean[2]};
}

/// A step and its F, in what F is made of: the identity but for its first eight rows, and these by
/// the velocity's (`velocity_by`), by the way (dx, dy) that a change of yaw swings, and by decays.
struct Step {
  Vector mean;
  Eigen::Matrix<double, 3, 8> velocity_by;  ///< ∂v'/∂(v_x ... stiffness_scale)
  double dt = 0.0;
  double dx = 0.0;  ///< of the pose
  double dy = 0.0;
  double c = 1.0;  ///< cos ψ_m, sin ψ_m
  double s = 0.0;
  double decay = 1.0;         ///< of front_force
  double moment_decay = 1.0;  ///< of yaw_moment
};
[[nodiscard]] Step step_linearised(const CarModel& model, const Input& input, const Vector& state,
                                   double dt) noexcept;

/// The first eight columns of P Fᵀ, x ... yaw_moment; the others are those of P.
[[nodiscard]] Eigen::Matrix<double, at::size, 8> times_transposed(const Matrix& P,
                                                                  const Step& F) noexcept;

/// Mean and covariance P after `dt` > 0 on the move.
void propagate(const CarModel& model, const Input& input, double dt, Vector& mean,
               Matrix& P) noexcept;

/// The covariance after `dt` of standing: only what varies slowly does so.
void propagate_standing(const CarModel& model, double dt, Matrix& covariance) noexcept;

}  // namespace odomd::estimator::full
