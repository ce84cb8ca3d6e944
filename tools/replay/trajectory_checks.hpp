// Detects poses that cannot be compared: from another drive, for only a part of the drive, in other
// axes, or in units other than metres and radians (wheels or gyro would then look wrong).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// Warns of an estimate that covers only a part of the drive: a file that was cut off or has a gap.
/// Nothing if it covers enough of the reference's path. Time at standstill does not count.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_coverage(const Trajectory& reference,
                                                                    const Trajectory& estimate);

/// Warns if reference and estimate belong to different drives, or look exchanged (only the
/// reference has sigmas). Their clocks start alike, so all figures would look like those of a bad
/// filter; but their turns differ from second to second. Nothing if the reference hardly turns.
[[nodiscard]] std::optional<diagnostics::Diagnostic> drive_mismatch(const Trajectory& reference,
                                                                    const Trajectory& estimate);

/// Warns of a file in degrees, or with a clockwise yaw. Nothing if the headings follow the path, or
/// if the car hardly moves or turns. A car that reverses or drifts gives no warning.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_headings(const Trajectory& trajectory);

/// Warns of an [initial] pose from the configuration of another drive: one far from the camera's
/// poses in the first fifth of a second; nothing if there are no such poses.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_initial_pose(
    const daemon::Config& config, std::span<const estimator::CameraPose> cameras,
    std::int64_t first_tick_ns);

/// The motion that poses are compared with. Only its distances and turns matter, not its start.
struct Driven {
  const Trajectory& trajectory;
  std::string way_of = "the wheels";  ///< source of the distances, in messages
  std::string turn_of = "the gyro";
};

/// Reports poses of `subject` that go a hundred or a thousand times as far as driven, or turn 57
/// times as far. Empty if they do not, or if the drive is too short to decide.
[[nodiscard]] diagnostics::Diagnostics check_units(const std::string& subject,
                                                   std::span<const TrajectoryPoint> poses,
                                                   const Driven& driven);

/// The same for poses of a camera, in any order.
[[nodiscard]] diagnostics::Diagnostics check_units(const std::string& subject,
                                                   std::span<const estimator::CameraPose> poses,
                                                   const Driven& driven);

}  // namespace odomd::tools
