// A reference from the camera's poses, for a drive without truth.
//
// Of each instant: the camera's next poses, carried back by the motion that the full filter saw
// meanwhile, whose sensors the camera has calibrated. No filter can know a pose that was
// taken after the instant that it publishes for: so each pose is held out from every estimate that
// it judges, and judging with the camera is not circular. docs/evaluation.md, "Drives without
// truth".
#pragma once

#include <optional>
#include <span>

#include "estimator/common/measurement.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// The poses of a camera as those of the centre of gravity, in the order in which they were taken.
[[nodiscard]] Trajectory camera_trajectory(std::span<const estimator::CameraPose> poses,
                                           const estimator::Pose2& lever_arm);

/// A row for each of the odometry's that enough poses follow. Its covariance is the noise that is
/// left, by the scatter of these poses: stated sigmas have no part in it. Nothing if that is less
/// than a second.
[[nodiscard]] std::optional<Trajectory> camera_reference(const Trajectory& camera,
                                                         const Trajectory& odometry);

/// The same of a drive, whether or not the camera's poses come in. Nothing without a camera. Needs
/// a replay.
[[nodiscard]] std::optional<Trajectory> camera_reference(const Drive& drive);

}  // namespace odomd::tools
