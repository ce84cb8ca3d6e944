// The slip odometer as a filter: heading by the integral of the gyro, speed by the wheels, side
// slip of a steady turn, the camera by the anchor. It learns nothing: the model to beat.
#pragma once

#include "estimator/baselines/held_signals.hpp"
#include "estimator/baselines/tick_filter.hpp"
#include "estimator/baselines/wheel_speed.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

/// Starts at the first wheel speed, with the pose where it was set. From then on the pose moves a
/// tick along the arc of the newest velocity. A gyro that was not heard yet counts as 0.
class InertialMotion {
 public:
  InertialMotion(const Vehicle& car, double dt) noexcept : car_(car), dt_(dt) {}

  /// Steering takes the speed of front wheels to the car's axis, where there are no others.
  [[nodiscard]] static bool uses(Source source) noexcept { return source != Source::accel_y; }
  [[nodiscard]] static double yaw_rate_at_wheels(const HeldSignals& held) noexcept {
    return held.value(Source::yaw_rate);
  }
  void advance(const HeldSignals& held, const AxleSpeed& speed, Pose2& odom) noexcept;
  void resume(const BodyVelocity& velocity, const Symmetric3& covariance) noexcept;

  [[nodiscard]] BodyVelocity velocity() const noexcept { return velocity_; }
  /// From the sigmas of speed and gyro through the model's Jacobian, and the side slip, which holds
  /// in a steady turn on linear tyres alone.
  [[nodiscard]] Symmetric3 velocity_covariance() const noexcept { return covariance_; }
  /// The yaw rate held: a gyro's differences are noise.
  [[nodiscard]] BodyVelocity acceleration(const HeldSignals& held) const noexcept;
  [[nodiscard]] static bool stopped() noexcept { return false; }
  [[nodiscard]] bool finite() const noexcept {
    return is_finite(velocity_) && is_finite(covariance_);
  }

 private:
  Vehicle car_;
  double dt_ = 0.005;
  bool moving_ = false;  ///< a tick has gone before
  BodyVelocity velocity_;
  Symmetric3 covariance_ = diagonal(1.0, 1.0, 1.0);
};

extern template class TickFilter<InertialMotion>;
using InertialFilter = TickFilter<InertialMotion>;

}  // namespace odomd::estimator
