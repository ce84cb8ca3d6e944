// Whose times are off, and what to do about it: the reference's, the camera's, or both.
#pragma once

#include <span>
#include <string>

#include "estimator/common/measurement.hpp"
#include "tools/evaluation/time_offset.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// What to say of a reference beside estimates that were read from files: of the log that they were
/// made of nothing is known. Empty where there is nothing to say.
[[nodiscard]] std::string time_doubt(const Trajectory& reference,
                                     std::span<const Trajectory> estimates, Align align);

/// The poses of a camera as those of the centre of gravity, in the order in which they were taken.
[[nodiscard]] Trajectory camera_trajectory(std::span<const estimator::CameraPose> poses,
                                           const estimator::Pose2& lever_arm);

/// The same of a drive, held against what it is by dead_reckoning(), which is on the log's clock.
/// The reference is that of the centre of gravity. Costs a replay.
[[nodiscard]] std::string time_doubt(const Trajectory& reference, const Drive& drive, Align align);

}  // namespace odomd::tools
