// The motion models that use the newest held signals, and their equations (docs/model.md, from "The
// kinematic model" to "The slip odometer"). All describe the motion of the centre of gravity.
// baseline_filter.hpp turns them into filters.
#pragma once

#include <Eigen/Core>

#include "estimator/baselines/signals.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

/// The motion at a tick, and over the period before it.
struct Motion {
  BodyVelocity velocity;
  Symmetric3 covariance{1.0, 0.0, 0.0, 1.0, 0.0, 1.0};  ///< of the velocity
  BodyVelocity rate;  ///< (v̇_x, v̇_y, ψ̈) of the model [m/s², m/s², rad/s²]
  BodyVelocity mean;  ///< velocity over the period
  Pose2 way;          ///< displacement over the period, in the car's axes before it
  /// Lasting errors of the inertial model: gyro bias [rad/s], gyro scale, wheel scale.
  Eigen::Matrix3d sensitivity = Eigen::Matrix3d::Zero();  ///< ∂velocity / ∂errors
  Eigen::Vector3d error_variance = Eigen::Vector3d::Zero();
  bool moving = false;   ///< the velocity comes from an earlier tick or a predecessor
  bool stopped = false;  ///< the model has left its domain: the velocity stays 0
};

/// B D Bᵀ: covariance from lasting errors with the variances D.
[[nodiscard]] inline Eigen::Matrix3d by_errors(const Eigen::Matrix3d& sensitivity,
                                               const Eigen::Vector3d& variance) noexcept {
  return sensitivity * variance.asDiagonal() * sensitivity.transpose();
}

/// The kinematic models derive the yaw rate from the steering.
[[nodiscard]] constexpr bool uses_gyro(Model model) noexcept {
  return model != Model::kinematic && model != Model::kinematic_printed;
}

/// One period with the newest signals; a signal without a sample counts as 0. The kinematic models
/// move along an arc with the mean velocity of the period, the inertial model with the newest
/// velocity. None of them moves in its first tick.
void advance_dead_reckoning(Model model, const FilterSettings& settings, const HeldSignals& held,
                            const GyroBias& bias, const AxleSpeed& speed, Motion& motion) noexcept;

/// The paper's filter as its author runs it: one prediction and one correction per tick, whatever
/// the times of the samples; then X, Y and ψ are integrated from the corrected state. It starts at
/// x = 0, P = I, and already moves in its first tick. Below a v_x of -0.05 m/s it stops.
void advance_paper(const FilterSettings& settings, const HeldSignals& held, const AxleSpeed& speed,
                   Motion& motion) noexcept;

struct DeadReckoning {
  BodyVelocity velocity;
  Eigen::Matrix<double, 3, 2> jacobian;  ///< ∂(v_x, v_y, ψ̇) / ∂(v_x, turn)
  double slip = 0.0;                     ///< possible error of v_y [m/s]
};

/// The velocity from v_x and `turn`. Kinematic models: `turn` is the steering δ, |δ| < π/2, and
/// there is no side slip. Inertial model: `turn` is the yaw rate ψ̇, and the side slip is that of a
/// steady turn, also in reverse.
[[nodiscard]] DeadReckoning reckon(Model model, const Vehicle& car, double v_x,
                                   double turn) noexcept;

/// The dynamic bicycle's (v̇_x, v̇_y, ψ̈), eqs 4-12. The divisor of the slip angles is at least
/// speed_floor > 0: at a larger |v_x| the angles equal the paper's; at rest they are 0.
[[nodiscard]] BodyVelocity dynamic_rate(const Vehicle& car, const BodyVelocity& v, double steering,
                                        double accel_x, double speed_floor) noexcept;

struct PaperStep {
  BodyVelocity velocity;
  Eigen::Matrix3d phi;  ///< Φ = ∂f/∂(v_x, v_y, ψ̇) before the step   (eq. 15, transition_matrix)
};

/// The dynamic bicycle, discrete as printed (eqs 31-33), with errata 1 and 2. For forward motion
/// only: the denominators vanish at a v_x just below 0, and the step is unstable slightly above it.
[[nodiscard]] PaperStep paper_step(const Vehicle& car, const BodyVelocity& v, double steering,
                                   double accel_x, double dt) noexcept;

/// Predicts and corrects the velocity with the paper's extended Kalman filter, for u = [δ, a_x] and
/// z = [ψ̇, v_x].
void step_paper_ekf(const FilterSettings& settings, const Eigen::Vector2d& u,
                    const Eigen::Vector2d& z, Motion& motion) noexcept;

}  // namespace odomd::estimator
