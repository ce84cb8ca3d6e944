// Says in which mode the estimate is, without flapping: what is entered late is left at a wider
// threshold, or after more than one event.
#pragma once

#include <cstdint>

#include "estimator/common/estimate.hpp"

namespace odomd::estimator {

/// What the mode depends on, at one tick.
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
  explicit ModeMonitor(double camera_timeout_s) noexcept : camera_timeout_s_(camera_timeout_s) {}

  /// Once a tick, in order of time. Precedence: fault, initialising, standstill, then
  /// dead_reckoning or tracking. (`degraded` is for those who know the bus.)
  Mode update(const ModeInputs& inputs) noexcept;

 private:
  void update_rest(const ModeInputs& inputs) noexcept;
  void update_tracking(const ModeInputs& inputs) noexcept;

  double camera_timeout_s_ = 0.5;

  bool resting_ = false;   ///< below the thresholds since rest_since_ns_
  bool standing_ = false;  ///< and that for long enough
  std::int64_t rest_since_ns_ = 0;

  bool tracking_ = false;
  std::int64_t last_camera_ns_ = 0;
};

}  // namespace odomd::estimator
