// Detects wrong times of the reference, the camera, or both, and says what to do.
#pragma once

#include <span>
#include <string>

#include "estimator/common/measurement.hpp"
#include "tools/evaluation/time_offset.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// A warning about the times of a reference compared with estimates that were read from files,
/// whose log is not known. Empty: no warning.
[[nodiscard]] std::string time_warning(const Trajectory& reference,
                                       std::span<const Trajectory> estimates, Align align);

/// The poses of a camera as those of the centre of gravity, in the order in which they were taken.
[[nodiscard]] Trajectory camera_trajectory(std::span<const estimator::CameraPose> poses,
                                           const estimator::Pose2& lever_arm);

/// The same for a drive, compared with dead_reckoning(), which is on the log's clock. The reference
/// is that of the centre of gravity. Needs a replay.
[[nodiscard]] std::string time_warning(const Trajectory& reference, const Drive& drive,
                                       Align align);

}  // namespace odomd::tools
