// The models of the car that are stepped with the newest signals held, and their equations
// (docs/model.md, from "The kinematic model" to "The slip odometer"). All of the centre of gravity.
// baseline_filter.hpp makes a filter of each.
#pragma once

#include <Eigen/Core>

#include "estimator/baselines/signals.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

/// Of the car at a tick, and over the period that led there.
struct Motion {
  BodyVelocity velocity;
  Symmetric3 covariance = diagonal(1.0, 1.0, 1.0);  ///< of the velocity
  BodyVelocity rate;     ///< (v̇_x, v̇_y, ψ̈) as the model has them [m/s², m/s², rad/s²]
  BodyVelocity mean;     ///< velocity over the period
  Pose2 way;             ///< of the period, in the axes of the car before it
  bool moving = false;   ///< the velocity is that of a tick before, or of a predecessor
  bool stopped = false;  ///< the model has left its domain: it stays where it is, for good
};

/// The kinematic models know the yaw rate from the steering alone.
[[nodiscard]] constexpr bool uses_gyro(Model model) noexcept {
  return model != Model::kinematic && model != Model::kinematic_printed;
}

/// One period with the newest signals; what was not heard yet counts as 0. The kinematic models
/// move along the arc of the mean of the velocities at both ends of the period, the inertial one
/// along that of the newest. Neither moves in its first tick.
void advance_dead_reckoning(Model model, const FilterSettings& settings, const HeldSignals& held,
                            const AxleSpeed& speed, Motion& motion) noexcept;

/// The paper's filter as its author runs it: each tick one predict and one correct, whatever the
/// samples' times; then X, Y and ψ from the corrected state. It starts at x = 0, P = I, and moves
/// already in its first tick. Below a v_x of -0.05 m/s it stops.
void advance_paper(const FilterSettings& settings, const HeldSignals& held, const AxleSpeed& speed,
                   Motion& motion) noexcept;

struct DeadReckoning {
  BodyVelocity velocity;
  Eigen::Matrix<double, 3, 2> jacobian;  ///< ∂(v_x, v_y, ψ̇) / ∂(v_x, turn)
  double slip = 0.0;                     ///< by which v_y may be wrong [m/s]
};

/// The velocity by v_x and by what turns the car: of the kinematic models, of which no wheel slips
/// sideways, δ, |δ| < π/2; of the inertial one ψ̇, with the side slip of a steady turn, in either
/// direction.
[[nodiscard]] DeadReckoning reckon(Model model, const Vehicle& car, double v_x,
                                   double turn) noexcept;

/// The dynamic bicycle's (v̇_x, v̇_y, ψ̈) (eqs 4-12). The slip angles divide by
/// max(|v_x|, speed_floor), speed_floor > 0: above it they are those of the paper, and at
/// standstill they fade to nothing instead of to infinity.
[[nodiscard]] BodyVelocity dynamic_rate(const Vehicle& car, const BodyVelocity& v, double steering,
                                        double accel_x, double speed_floor) noexcept;

struct PaperStep {
  BodyVelocity velocity;
  Eigen::Matrix3d phi;  ///< Φ = ∂f/∂(v_x, v_y, ψ̇) before the step   (eq. 15, transition_matrix)
};

/// The dynamic bicycle, discrete as printed (eqs 31-33), with errata 1 and 2. Forward only: its
/// denominators vanish just below 0, and the map is unstable before.
[[nodiscard]] PaperStep paper_step(const Vehicle& car, const BodyVelocity& v, double steering,
                                   double accel_x, double dt) noexcept;

/// The paper's extended Kalman filter, bare: a predict and a correct of the velocity with
/// u = [δ, a_x] and z = [ψ̇, v_x].
void step_paper_ekf(const FilterSettings& settings, const Eigen::Vector2d& u,
                    const Eigen::Vector2d& z, Motion& motion) noexcept;

}  // namespace odomd::estimator
