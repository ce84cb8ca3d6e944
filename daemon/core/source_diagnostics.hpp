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
  using diagnostics::kind, estimator::SourceFlag;
  struct Row {
    SourceFlag flag;
    const diagnostics::Kind& kind;
    std::string_view seen;
  };
  static constexpr Row rows[]{
      {SourceFlag::out_of_range, kind("out_of_range"), "out of range for a car"},
      {SourceFlag::non_finite, kind("not_a_number"), "NaN or infinite"},
      {SourceFlag::frozen, kind("frozen"), "frozen: it repeats one value while the car moves"},
      {SourceFlag::drifting, kind("contradicts_others"), "contradicts the other sensors"},
      {SourceFlag::failed_protection, kind("protection_failed"),
       "fails its end-to-end protection"}};
  static_assert(std::size(rows) + 3 == static_cast<std::size_t>(SourceFlag::count),
                "all flags but ok, slipping and timed_out have a row");
  for (const Row& row : rows)
    if (row.flag == flag) return found(row.kind, std::move(label), std::string{row.seen});
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
  using diagnostics::kind;
  struct Row {
    WiringFault fault;
    const diagnostics::Kind& kind;
    const diagnostics::Kind& camera;
    std::string_view seen;
  };
  static constexpr Row rows[]{
      {WiringFault::sign, kind("wrong_sign"), kind("camera_mirrored"),
       "the sign is wrong compared with the other sensors"},
      {WiringFault::left_right_swapped, kind("left_right_swapped"), kind("left_right_swapped"),
       "the left and right wheels are swapped, according to the other sensors"},
      {WiringFault::front_rear_swapped, kind("front_rear_swapped"), kind("front_rear_swapped"),
       "the wheels of the front and rear axles are swapped: in turns the front wheels must travel "
       "further"},
      {WiringFault::axes_swapped, kind("axes_swapped"), kind("axes_swapped"),
       "the axes of the accelerometer are swapped: it shows lateral acceleration when the car "
       "speeds up"},
      {WiringFault::unit, kind("wrong_unit"), kind("camera_wrong_unit"),
       "is in another unit, according to the other sensors"}};
  static_assert(std::size(rows) + 1 == static_cast<std::size_t>(WiringFault::count),
                "all faults have a row");
  for (const Row& row : rows)
    if (row.fault == fault)
      return found(source == "camera" ? row.camera : row.kind, std::move(label),
                   std::string{row.seen}, "can.signals." + std::string{source});
  return std::nullopt;
}

}  // namespace odomd::daemon
