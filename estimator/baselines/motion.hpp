// The models of the car that are stepped with the newest signals held, and their equations
// (docs/model.md, from "The kinematic model" to "The slip odometer"). All of the centre of gravity.
// baseline_filter.hpp makes a filter of each.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "estimator/baselines/signals.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

struct Motion {
  Pose2 odom;
  BodyVelocity velocity;
  Symmetric3 covariance = diagonal(1.0, 1.0, 1.0);  ///< of the velocity
  bool moving = false;   ///< the velocity is that of a tick before, or of a predecessor
  bool stopped = false;  ///< the model has left its domain: it stays where it is, for good
};

/// Two functions of the motion so far and the signals held. A signal that was not heard yet counts
/// as 0.
struct MotionModel {
  /// Else the yaw rate is the model's own, and a gyro's samples get the verdict source_off.
  bool uses_gyro;
  /// By one period.
  void (*advance)(const FilterSettings& settings, const HeldSignals& held, const AxleSpeed& speed,
                  Motion& motion) noexcept;
  /// (v̇_x, v̇_y, ψ̈)
  BodyVelocity (*acceleration)(const FilterSettings& settings, const HeldSignals& held,
                               const Motion& motion) noexcept;
};

/// Start at the first wheel speed, with the pose where it was set. From then on the kinematic ones
/// move a tick along the arc of the mean of the velocities at both ends of it, the slip odometer
/// along that of the newest.
extern const MotionModel kinematic_motion, kinematic_motion_as_printed, inertial_motion;
/// As its author runs it: each tick one predict and one correct with the newest value of each
/// signal, whatever its time; then X, Y and ψ from the corrected state. Starts at x = 0, P = I, and
/// moves already in its first tick. Below a v_x of -0.05 m/s it stops.
extern const MotionModel paper_motion;

struct DeadReckoning {
  BodyVelocity velocity;
  Eigen::Matrix<double, 3, 2> jacobian;  ///< ∂(v_x, v_y, ψ̇) / ∂(v_x, δ) or ∂(v_x, ψ̇)
  double slip = 0.0;                     ///< by which v_y may be wrong [m/s]
};

enum class KinematicForm : std::uint8_t {
  centre_of_gravity,  ///< v_y = l_h ψ̇
  printed,            ///< v_y = 0: eqs 2 and 3, which hold for the rear axle
};

/// The bicycle of which no wheel slips sideways. |δ| < π/2.
[[nodiscard]] DeadReckoning kinematic(const Vehicle& car, KinematicForm form, double v_x,
                                      double steering) noexcept;

/// Turned by the gyro, with the side slip of a steady turn, in either direction.
[[nodiscard]] DeadReckoning inertial(const Vehicle& car, double v_x, double yaw_rate) noexcept;

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
/// denominators vanish at v_x = -Δt (C_v + C_h) / m and -Δt (l_v² C_v + l_h² C_h) / J_z (-0.134 and
/// -0.185 m/s for the reference car at 5 ms), and the map is unstable below about -0.06 m/s.
[[nodiscard]] PaperStep paper_step(const Vehicle& car, const BodyVelocity& v, double steering,
                                   double accel_x, double dt) noexcept;

/// The paper's extended Kalman filter of x = [v_x, v_y, ψ̇], with the inputs δ and a_x, and the
/// measured ψ̇ and v_x. Of the settings: the car, the period, the paper's noise.
void predict(const FilterSettings& settings, double steering, double accel_x,
             Motion& motion) noexcept;
void correct(const FilterSettings& settings, double yaw_rate, double v_x, Motion& motion) noexcept;

}  // namespace odomd::estimator
