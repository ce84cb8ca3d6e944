// The models that advance with the newest signals held, and their equations (docs/model.md, from
// "The kinematic model" to "The slip odometer"). All for the centre of gravity. baseline_filter.hpp
// makes a filter of each.
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
  /// Errors that last: the gyro's bias [rad/s], its scale, the wheels' scale. Of the inertial
  /// model.
  Eigen::Matrix3d sensitivity = Eigen::Matrix3d::Zero();  ///< ∂velocity / ∂errors
  Eigen::Vector3d error_variance = Eigen::Vector3d::Zero();
  bool moving = false;   ///< the velocity comes from an earlier tick or a predecessor
  bool stopped = false;  ///< the model has left its domain: it stands still for good
};

/// B D Bᵀ: the covariance by lasting errors of variances D.
[[nodiscard]] inline Eigen::Matrix3d by_errors(const Eigen::Matrix3d& sensitivity,
                                               const Eigen::Vector3d& variance) noexcept {
  return sensitivity * variance.asDiagonal() * sensitivity.transpose();
}

/// The kinematic models derive the yaw rate from the steering.
[[nodiscard]] constexpr bool uses_gyro(Model model) noexcept {
  return model != Model::kinematic && model != Model::kinematic_printed;
}

/// One period with the newest signals; a signal without a sample counts as 0. The kinematic models
/// move along the arc of the mean velocity of the period, the inertial one along that of the
/// newest. Neither moves in its first tick.
void advance_dead_reckoning(Model model, const FilterSettings& settings, const HeldSignals& held,
                            const GyroBias& bias, const AxleSpeed& speed, Motion& motion) noexcept;

/// The paper's filter as its author runs it: each tick one predict and one correct, whatever the
/// samples' times; then X, Y and ψ from the corrected state. It starts at x = 0, P = I, and moves
/// in its first tick already. Below a v_x of -0.05 m/s it stops.
void advance_paper(const FilterSettings& settings, const HeldSignals& held, const AxleSpeed& speed,
                   Motion& motion) noexcept;

struct DeadReckoning {
  BodyVelocity velocity;
  Eigen::Matrix<double, 3, 2> jacobian;  ///< ∂(v_x, v_y, ψ̇) / ∂(v_x, turn)
  double slip = 0.0;                     ///< possible error of v_y [m/s]
};

/// The velocity by v_x and `turn`: for the kinematic models the steering δ, |δ| < π/2, without side
/// slip; for the inertial one the yaw rate ψ̇, with the side slip of a steady turn, in either
/// direction.
[[nodiscard]] DeadReckoning reckon(Model model, const Vehicle& car, double v_x,
                                   double turn) noexcept;

/// The dynamic bicycle's (v̇_x, v̇_y, ψ̈) (eqs 4-12). The slip angles divide by
/// max(|v_x|, speed_floor), speed_floor > 0: equal to those of the paper above it, and 0 at
/// standstill.
[[nodiscard]] BodyVelocity dynamic_rate(const Vehicle& car, const BodyVelocity& v, double steering,
                                        double accel_x, double speed_floor) noexcept;

struct PaperStep {
  BodyVelocity velocity;
  Eigen::Matrix3d phi;  ///< Φ = ∂f/∂(v_x, v_y, ψ̇) before the step   (eq. 15, transition_matrix)
};

/// The dynamic bicycle, discrete as printed (eqs 31-33), with errata 1 and 2. Forward only: the
/// denominators vanish just below 0, and the map is unstable before.
[[nodiscard]] PaperStep paper_step(const Vehicle& car, const BodyVelocity& v, double steering,
                                   double accel_x, double dt) noexcept;

/// Predict and correct of the paper's extended Kalman filter for the velocity, with u = [δ, a_x]
/// and z = [ψ̇, v_x].
void step_paper_ekf(const FilterSettings& settings, const Eigen::Vector2d& u,
                    const Eigen::Vector2d& z, Motion& motion) noexcept;

}  // namespace odomd::estimator
