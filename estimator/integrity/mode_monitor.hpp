// The mode of the estimate, with hysteresis. docs/model.md, "Modes".
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "estimator/common/estimate.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/time.hpp"
#include "estimator/common/vehicle.hpp"

namespace odomd::estimator {

class ModeMonitor {
 public:
  /// The mode for an estimate; `still`: the car is still at this instant. Call it once a tick, in
  /// order of time. Precedence: fault, initialising, standstill, then tracking or dead_reckoning.
  /// (The daemon sets `degraded`.)
  Mode update(const Estimate& now, bool still) noexcept {
    still_since_ns_ = still ? still_since_ns_.value_or(now.time_ns) : std::optional<std::int64_t>();
    standing_ = still && seconds_between(*still_since_ns_, now.time_ns) >= standing_after_s;
    // It takes two poses within the timeout to enter `tracking`, so that rare poses do not make the
    // mode flap.
    const bool seen_twice = last_camera_ns_ != 0 && now.camera_ns != last_camera_ns_ &&
                            seconds_between(last_camera_ns_, now.camera_ns) <= camera_timeout_s;
    const bool seen_lately =
        now.camera_ns != 0 && seconds_between(now.camera_ns, now.time_ns) <= camera_timeout_s;
    tracking_ = seen_lately && (tracking_ || seen_twice);
    last_camera_ns_ = now.camera_ns;
    return now.model_fault    ? Mode::fault
           : !now.initialised ? Mode::initialising
           : standing_        ? Mode::standstill
           : tracking_        ? Mode::tracking
                              : Mode::dead_reckoning;
  }

  /// Whether a measured motion counts as rest. The thresholds are twice as large while the car
  /// stands.
  [[nodiscard]] bool is_still(double speed, double yaw_rate) const noexcept {
    constexpr double standing_yaw_rate = 0.1;  // [rad/s]: above a gyro's bias and noise
    const double wider = standing_ ? 2.0 : 1.0;
    return std::abs(speed) < wider * slowest_turning &&
           std::abs(yaw_rate) < wider * standing_yaw_rate;
  }

 private:
  static constexpr double standing_after_s = 0.5;

  std::optional<std::int64_t> still_since_ns_;
  bool standing_ = false;  ///< still for long enough
  bool tracking_ = false;
  std::int64_t last_camera_ns_ = 0;
};

}  // namespace odomd::estimator
