// What a flag of a source says, in words: the daemon's as it runs, and those who replay a drive.
#pragma once

#include <string>
#include <string_view>

#include "daemon/core/wiring.hpp"
#include "estimator/integrity/integrity.hpp"

namespace odomd::daemon {

/// Goes on behind the source's name.
[[nodiscard]] constexpr std::string_view complaint(estimator::SourceFlag flag) noexcept {
  using estimator::SourceFlag;
  switch (flag) {
    case SourceFlag::out_of_range:
      return " is out of range: no car does that; look at its scale and wiring";
    case SourceFlag::non_finite:
      return " is no number";
    case SourceFlag::frozen:
      return " is frozen: it repeats one value while the car moves on";
    case SourceFlag::drifting:
      return " contradicts the other sensors: look at its scale, offset and mounting";
    default:
      return " fails its protection: look at the status";
  }
}

inline constexpr std::string_view inconsistent_complaint =
    " does not fit what the filter expects, for seconds: look at its sigma, latency and scale, and "
    "at the vehicle";

/// Likewise of a mistake in the wiring or the description; `source` names the key.
[[nodiscard]] inline std::string complaint(WiringFault fault, std::string_view source) {
  const std::string key = source == "camera" ? "" : "can.signals." + std::string{source};
  switch (fault) {
    case WiringFault::none:
    case WiringFault::count:
      return {};
    case WiringFault::sign:
      return " has the wrong sign, by all the others: " +
             (key.empty() ? std::string{"is its yaw counter-clockwise, and its map not mirrored?"}
                          : "look at the sign of " + key + ".scale");
    case WiringFault::left_right_swapped:
      return ": the wheels of the left and the right are swapped, by all the others: look at the "
             "signal of " +
             key;
    case WiringFault::front_rear_swapped:
      return ": the wheels of the front and the rear axle are swapped: in turns the front ones "
             "must go the longer way; look at the signal of " +
             key;
    case WiringFault::axes_swapped:
      return ": the axes of the accelerometer are swapped: what must come in turns comes with "
             "the throttle; look at the signal of " +
             key + ", or at imu.yaw";
    case WiringFault::unit:
      return " is in another unit, by all the others: " +
             (key.empty() ? std::string{"positions must be in metres"}
                          : "look at unit and scale of " + key);
  }
  return {};
}

}  // namespace odomd::daemon
