// A reference from the camera's poses, for a drive without truth.
//
// The pose at an instant comes from the camera's next poses, carried back with the odometry of the
// full filter, whose sensors the camera has calibrated. A filter never knows a pose that was taken
// after the instant for which it publishes. So no estimate uses the poses that it is compared with,
// and the comparison is not circular. docs/evaluation.md, "Drives without truth".
#pragma once

#include <optional>
#include <span>

#include "estimator/common/measurement.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// The camera's poses converted to the centre of gravity, in the order of their capture.
[[nodiscard]] Trajectory camera_trajectory(std::span<const estimator::CameraPose> poses,
                                           const estimator::Pose2& lever_arm);

/// One row for each row of the odometry that enough poses follow. Its covariance is the remaining
/// noise, from the scatter of these poses and not from their stated sigmas. Nothing if the rows
/// span less than a second.
[[nodiscard]] std::optional<Trajectory> camera_reference(const Trajectory& camera,
                                                         const Trajectory& odometry);

/// The reference of a drive from its camera poses, even if its replays leave the camera out.
/// Replays the drive. Nothing if there are no camera poses.
[[nodiscard]] std::optional<Trajectory> camera_reference(const Drive& drive);

}  // namespace odomd::tools
