// The diagnostics of a source, for the daemon's log and for replays.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/core/wiring.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// A flag's diagnostic; nothing for a source that is fine, slips or is overdue. `label` names the
/// source: "yaw_rate (IMU)".
[[nodiscard]] inline std::optional<diagnostics::Diagnostic> diagnostic_of(
    estimator::SourceFlag flag, std::string label) {
  using diagnostics::found, diagnostics::kind, estimator::SourceFlag;
  switch (flag) {
    case SourceFlag::out_of_range:
      return found(kind("out_of_range"), std::move(label), "out of range for a car");
    case SourceFlag::non_finite:
      return found(kind("not_a_number"), std::move(label), "NaN or infinite");
    case SourceFlag::frozen:
      return found(kind("frozen"), std::move(label),
                   "frozen: it repeats one value while the car moves");
    case SourceFlag::drifting:
      return found(kind("contradicts_others"), std::move(label), "contradicts the other sensors");
    case SourceFlag::failed_protection:
      return found(kind("protection_failed"), std::move(label), "fails its end-to-end protection");
    case SourceFlag::ok:
    case SourceFlag::slipping:
    case SourceFlag::timed_out:
    case SourceFlag::count:
      break;
  }
  return std::nullopt;
}

[[nodiscard]] inline diagnostics::Diagnostic inconsistent_source(std::string label) {
  return found(diagnostics::kind("inconsistent"), std::move(label),
               "has not fitted the filter's prediction for seconds");
}

[[nodiscard]] inline diagnostics::Diagnostic unlearnt_bias() {
  return found(diagnostics::kind("bias_unlearnt"), "yaw_rate", "the gyro's bias is not known");
}

[[nodiscard]] inline diagnostics::Diagnostic implausible_scale() {
  return found(diagnostics::kind("scale_implausible"), "calibrations",
               "a learnt scale is far from its configured value");
}

/// The diagnostic of a wiring fault; its key is "can.signals.SOURCE".
[[nodiscard]] inline std::optional<diagnostics::Diagnostic> diagnostic_of(WiringFault fault,
                                                                          std::string_view source,
                                                                          std::string label) {
  using diagnostics::found, diagnostics::kind;
  const bool is_camera = source == "camera";
  const std::string key = "can.signals." + std::string{source};
  switch (fault) {
    case WiringFault::sign:
      return found(is_camera ? kind("camera_mirrored") : kind("wrong_sign"), std::move(label),
                   "the sign is wrong compared with the other sensors", key);
    case WiringFault::left_right_swapped:
      return found(kind("left_right_swapped"), std::move(label),
                   "the left and right wheels are swapped, according to the other sensors", key);
    case WiringFault::front_rear_swapped:
      return found(kind("front_rear_swapped"), std::move(label),
                   "the wheels of the front and rear axles are swapped: in turns the front wheels "
                   "must travel further",
                   key);
    case WiringFault::axes_swapped:
      return found(kind("axes_swapped"), std::move(label),
                   "the axes of the accelerometer are swapped: it shows lateral acceleration when "
                   "the car speeds up",
                   key);
    case WiringFault::unit:
      return found(is_camera ? kind("camera_wrong_unit") : kind("wrong_unit"), std::move(label),
                   "is in another unit, according to the other sensors", key);
    case WiringFault::none:
    case WiringFault::count:
      break;
  }
  return std::nullopt;
}

}  // namespace odomd::daemon
