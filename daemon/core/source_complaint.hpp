// The texts of warnings about a source, for the daemon's log and for replays.
#pragma once

#include <string>
#include <string_view>

#include "daemon/core/wiring.hpp"
#include "estimator/integrity/integrity.hpp"

namespace odomd::daemon {

/// Follows the name of the source.
[[nodiscard]] constexpr std::string_view complaint(estimator::SourceFlag flag) noexcept {
  using estimator::SourceFlag;
  switch (flag) {
    case SourceFlag::out_of_range:
      return " is out of range for a car; check its scale and wiring";
    case SourceFlag::non_finite:
      return " is NaN or infinite";
    case SourceFlag::frozen:
      return " is frozen: it repeats one value while the car moves";
    case SourceFlag::drifting:
      return " contradicts the other sensors; check its scale, offset and mounting";
    default:
      return " fails its end-to-end protection; see odom status";
  }
}

inline constexpr std::string_view inconsistent_complaint =
    " has not fitted the filter's prediction for seconds; check its sigma, latency and scale, and "
    "[vehicle]";

/// The same for a fault in the wiring or its description; `source` gives the key.
[[nodiscard]] inline std::string complaint(WiringFault fault, std::string_view source) {
  const std::string key = source == "camera" ? "" : "can.signals." + std::string{source};
  switch (fault) {
    case WiringFault::none:
    case WiringFault::count:
      return {};
    case WiringFault::sign:
      return " has the wrong sign compared with the other sensors; " +
             (key.empty() ? std::string{"check that its yaw is counter-clockwise and its map is "
                                        "not mirrored"}
                          : "check the sign of " + key + ".scale");
    case WiringFault::left_right_swapped:
      return ": the left and right wheels are swapped, according to the other sensors; check the "
             "signal of " +
             key;
    case WiringFault::front_rear_swapped:
      return ": the wheels of the front and rear axles are swapped: in turns the front wheels must "
             "travel further; check the signal of " +
             key;
    case WiringFault::axes_swapped:
      return ": the axes of the accelerometer are swapped: it shows lateral acceleration when the "
             "car speeds up; check the signal of " +
             key + ", or at imu.yaw";
    case WiringFault::unit:
      return " is in another unit, according to the other sensors; " +
             (key.empty() ? std::string{"its positions must be in metres"}
                          : "check unit and scale of " + key);
  }
  return {};
}

}  // namespace odomd::daemon
