// Detects poses that cannot be compared: of another drive, of a part of it, or in other axes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// An estimate of a part of the drive only: a file that was cut off or has a gap. Nothing if it
/// covers enough of the reference's path. Time at standstill does not count.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_coverage(const Trajectory& reference,
                                                                    const Trajectory& estimate);

/// A reference of another drive: both clocks start alike, so every figure would look like that of a
/// bad filter. Whether the two turn so differently from second to second that they cannot be of one
/// drive, or look exchanged (sigmas in the reference alone). Nothing if the reference hardly turns.
[[nodiscard]] std::optional<diagnostics::Diagnostic> drive_mismatch(const Trajectory& reference,
                                                                    const Trajectory& estimate);

/// A file in degrees, or with a clockwise yaw. Nothing if the headings follow the path, or if the
/// car hardly moves or turns. A car that reverses or drifts gives no warning.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_headings(const Trajectory& trajectory);

/// An [initial] pose from the configuration of another drive: far from the camera's poses in the
/// first fifth of a second; nothing if there are none.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_initial_pose(
    const daemon::Config& config, std::span<const estimator::CameraPose> cameras,
    std::int64_t first_tick_ns);

}  // namespace odomd::tools
