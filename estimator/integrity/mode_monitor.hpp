// Says in which mode the estimate is, without flapping: what is entered late is left at a wider
// threshold, or after more than one event. docs/model.md, "Modes".
#pragma once

#include <cstdint>
#include <optional>

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

  /// Once a tick, in order of time. Precedence: fault, initialising, standstill, then tracking or
  /// dead_reckoning. (`degraded` is for those who know the bus.)
  Mode update(const ModeInputs& inputs) noexcept;

 private:
  double camera_timeout_s_ = 0.5;
  std::optional<std::int64_t> still_since_ns_;
  bool standing_ = false;  ///< still for long enough
  bool tracking_ = false;
  std::int64_t last_camera_ns_ = 0;
};

}  // namespace odomd::estimator
