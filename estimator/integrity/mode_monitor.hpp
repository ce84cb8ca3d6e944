// The mode of the estimate, with hysteresis. docs/model.md, "Modes".
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "estimator/common/estimate.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/time.hpp"

namespace odomd::estimator {

struct ModeInputs {
  std::int64_t time_ns = 0;
  bool initialised = false;
  bool fault = false;
  double wheel_speed = 0.0;    ///< measured [m/s]
  double yaw_rate = 0.0;       ///< estimated [rad/s]
  std::int64_t camera_ns = 0;  ///< capture of the last fused camera pose; 0: none
};

class ModeMonitor {
 public:
  /// Once a tick, in order of time. Precedence: fault, initialising, standstill, then tracking or
  /// dead_reckoning. (The daemon sets `degraded`.)
  Mode update(const ModeInputs& inputs) noexcept;

 private:
  static constexpr double standing_speed = 0.01;    // [m/s]
  static constexpr double standing_yaw_rate = 0.1;  // [rad/s]: above a gyro's bias and noise
  static constexpr double leaves_at = 2.0;          // times the thresholds above
  static constexpr double standing_after_s = 0.5;

  std::optional<std::int64_t> still_since_ns_;
  bool standing_ = false;  ///< still for long enough
  bool tracking_ = false;
  std::int64_t last_camera_ns_ = 0;
};

inline Mode ModeMonitor::update(const ModeInputs& inputs) noexcept {
  const std::int64_t now_ns = inputs.time_ns;
  const double wider = standing_ ? leaves_at : 1.0;
  const bool still = std::abs(inputs.wheel_speed) < wider * standing_speed &&
                     std::abs(inputs.yaw_rate) < wider * standing_yaw_rate;
  if (!still) {
    still_since_ns_.reset();
  } else if (!still_since_ns_) {
    still_since_ns_ = now_ns;
  }
  standing_ = still_since_ns_ && seconds_between(*still_since_ns_, now_ns) >= standing_after_s;

  // It takes two poses within the timeout to enter `tracking`, so that rare poses do not make the
  // mode flap.
  const bool seen_twice = last_camera_ns_ != 0 && inputs.camera_ns != last_camera_ns_ &&
                          seconds_between(last_camera_ns_, inputs.camera_ns) <= camera_timeout_s;
  const bool seen_lately =
      inputs.camera_ns != 0 && seconds_between(inputs.camera_ns, now_ns) <= camera_timeout_s;
  tracking_ = seen_lately && (tracking_ || seen_twice);
  last_camera_ns_ = inputs.camera_ns;

  return inputs.fault          ? Mode::fault
         : !inputs.initialised ? Mode::initialising
         : standing_           ? Mode::standstill
         : tracking_           ? Mode::tracking
                               : Mode::dead_reckoning;
}

}  // namespace odomd::estimator
