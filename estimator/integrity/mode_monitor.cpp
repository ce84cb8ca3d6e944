#include "estimator/integrity/mode_monitor.hpp"

#include <cmath>

#include "estimator/common/time.hpp"

namespace odomd::estimator {
namespace {

constexpr double standing_speed = 0.01;    // [m/s]: enters standstill below
constexpr double moving_speed = 0.02;      // [m/s]: leaves it above
constexpr double standing_yaw_rate = 0.1;  // [rad/s]: above a gyro's bias and noise
constexpr double moving_yaw_rate = 0.2;    // [rad/s]
constexpr double standing_after_s = 0.5;

}  // namespace

Mode ModeMonitor::update(const ModeInputs& inputs) noexcept {
  update_rest(inputs);
  update_tracking(inputs);
  if (inputs.fault) {
    return Mode::fault;
  }
  if (!inputs.initialised) {
    return Mode::initialising;
  }
  if (standing_) {
    return Mode::standstill;
  }
  return tracking_ ? Mode::tracking : Mode::dead_reckoning;
}

void ModeMonitor::update_rest(const ModeInputs& inputs) noexcept {
  const double speed = std::abs(inputs.wheel_speed);
  const double yaw_rate = std::abs(inputs.yaw_rate);
  const bool still = speed < (standing_ ? moving_speed : standing_speed) &&
                     yaw_rate < (standing_ ? moving_yaw_rate : standing_yaw_rate);
  if (!still) {
    resting_ = false;
    standing_ = false;
    return;
  }
  if (!resting_) {
    resting_ = true;
    rest_since_ns_ = inputs.time_ns;
  }
  standing_ = standing_ || seconds_between(rest_since_ns_, inputs.time_ns) >= standing_after_s;
}

// Left when the last fused pose is too old; entered again by two poses that are not too far apart,
// so that a camera that sees the map once in a while does not make the mode flap.
void ModeMonitor::update_tracking(const ModeInputs& inputs) noexcept {
  const bool none_yet = inputs.camera_ns == 0;
  if (none_yet || seconds_between(inputs.camera_ns, inputs.time_ns) > camera_timeout_s_) {
    tracking_ = false;
  } else if (inputs.camera_ns != last_camera_ns_ && last_camera_ns_ != 0) {
    tracking_ =
        tracking_ || seconds_between(last_camera_ns_, inputs.camera_ns) <= camera_timeout_s_;
  }
  last_camera_ns_ = inputs.camera_ns;
}

}  // namespace odomd::estimator
