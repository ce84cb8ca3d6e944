// The kinematic model as a filter: dead reckoning by wheel speed and steering, the camera by the
// anchor. No gyro.
#pragma once

#include "estimator/baselines/held_signals.hpp"
#include "estimator/baselines/kinematic_model.hpp"
#include "estimator/baselines/tick_filter.hpp"
#include "estimator/baselines/wheel_speed.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

/// Starts at the first wheel speed, with the pose where it was set. From then on the pose moves a
/// tick along the arc of the mean of the velocities at both ends of it.
class KinematicMotion {
 public:
  KinematicMotion(const Vehicle& car, KinematicForm form, double dt) noexcept
      : car_(car), form_(form), dt_(dt) {}

  [[nodiscard]] static bool uses(Source source) noexcept {
    return source != Source::yaw_rate && source != Source::accel_y;
  }
  [[nodiscard]] double yaw_rate_at_wheels(const HeldSignals&) const noexcept {
    return velocity_.yaw_rate;
  }
  void advance(const HeldSignals& held, const AxleSpeed& speed, Pose2& odom) noexcept;
  void resume(const BodyVelocity& velocity, const Symmetric3& covariance) noexcept;

  [[nodiscard]] BodyVelocity velocity() const noexcept { return velocity_; }
  /// From the sigmas of speed and steering through the model's Jacobian, and what the model leaves
  /// out: the side slip of the rear axle.
  [[nodiscard]] Symmetric3 velocity_covariance() const noexcept { return covariance_; }
  [[nodiscard]] BodyVelocity acceleration(const HeldSignals& held) const noexcept;
  [[nodiscard]] static bool stopped() noexcept { return false; }
  [[nodiscard]] bool finite() const noexcept {
    return is_finite(velocity_) && is_finite(covariance_);
  }

 private:
  Vehicle car_;
  KinematicForm form_ = KinematicForm::centre_of_gravity;
  double dt_ = 0.005;
  bool moving_ = false;  ///< velocity_ is that of the tick before
  BodyVelocity velocity_;
  Symmetric3 covariance_ = diagonal(1.0, 1.0, 1.0);
};

extern template class TickFilter<KinematicMotion>;
using KinematicFilter = TickFilter<KinematicMotion>;

}  // namespace odomd::estimator
