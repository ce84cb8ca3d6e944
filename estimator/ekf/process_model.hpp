// The process model: the reversible discrete bicycle (errata, 5) with tyres that saturate; the pose
// from the mean velocity of a step; Jacobian and process noise.
//
// docs/model.md, "Process".
#pragma once

#include <array>

#include <Eigen/Core>

#include "estimator/common/settings.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/integrity/equations.hpp"

namespace odomd::estimator::full {

/// The input of a step.
struct Input {
  double steering = 0.0;  ///< δ after the actuator [rad]
  bool has_steering = false;
  double change = 0.0;  ///< change of δ in the step [rad]
};

/// Constant parameters of the model.
struct CarModel : integrity::Sensors {
  std::array<double, 2> imu_position{};  ///< (p_x, p_y), from the centre of gravity [m]
  double gyro_sigma = default_sigma[index_of(Source::yaw_rate)];  ///< the stated sigma [rad/s]
};

/// The quantities that change the velocity.
struct Moving {
  double v_x, v_y, yaw_rate;
  double accel_x;      ///< a_x
  double front_wheel;  ///< δ - δ_0 + ε
  double side_force;   ///< e
  double stiffness;    ///< 1 + κ
  double softness;     ///< 1/μ in addition to the car's [s²/m]
};

/// 1/μ [s²/m] of an axle, if its softness has no error.
[[nodiscard]] inline double usual_softness(double grip) noexcept {
  return grip > 0.0 ? 1.0 / grip : Tuning{}.tyre_softness;
}

/// Secant stiffness F(α) / α of an axle with a brush tyre, and its derivative with respect to the
/// softness 1/μ: C (1 - q + q²/3) with q = C |α| / (3 μ m_a) < 1, otherwise μ m_a / |α| (sliding).
/// μ is F_max / m_a [m/s²], m_a the axle's share of m; a softness of 0: linear.
struct Secant {
  double stiffness = 0.0;
  double by_softness = 0.0;
};
[[nodiscard]] Secant secant_stiffness(double stiffness, double slip_angle, double softness,
                                      double share_of_mass) noexcept;

/// A step of (v_x, v_y, ψ̇) and its derivatives.
///
///   v_x,k = v_x + Δt (a_x + v_y ψ̇)                                            (errata, 4)
///   v_y,k, ψ̇_k: eqs 32 and 33 with |v_x| for v_x in the inertia terms (errata, 1, 2 and 5), the
///   secant stiffnesses at the start of the step for C, and δ - δ_0 + ε for δ
struct VelocityStep {
  Eigen::Vector3d velocity;
  Eigen::Matrix<double, 3, 3> by;  ///< ∂/∂(v_x, v_y, ψ̇)
  double by_side_force = 0.0;      ///< ∂v_y/∂e
  Eigen::Vector2d by_front_wheel;  ///< ∂(v_y, ψ̇)/∂(δ - δ_0 + ε)
  Eigen::Vector2d by_stiffness;    ///< ∂(v_y, ψ̇)/∂κ
  Eigen::Vector2d by_softness;     ///< ∂(v_y, ψ̇)/∂(1/μ)
};
[[nodiscard]] VelocityStep velocity_step(const Vehicle& car, const Moving& now, double dt) noexcept;

/// The velocity after `steps` equal steps that take `time_s` in total, with a_x decaying.
[[nodiscard]] Eigen::Vector3d velocity_after(const CarModel& model, Moving now, double time_s,
                                             long steps) noexcept;

/// The quantities of a state that change the velocity.
[[nodiscard]] Moving moving(const State& state, const Input& input) noexcept;

/// Propagates mean, covariance and sensitivity of a moving car by `dt` > 0.
void propagate(const CarModel& model, const Input& input, double dt, State& state) noexcept;

/// Propagates the covariances at standstill: only the random walks grow.
void propagate_standing(const CarModel& model, double dt, State& state) noexcept;

}  // namespace odomd::estimator::full
