// A published pose as a point of a trajectory.
#pragma once

#include <odom/types.h>

#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

[[nodiscard]] inline TrajectoryPoint point_of(const odom_pose& pose, Frame frame) {
  TrajectoryPoint point;
  point.t_ns = pose.time_ns;
  point.pose = frame == Frame::odom ? estimator::Pose2{pose.odom_x, pose.odom_y, pose.odom_yaw}
                                    : estimator::Pose2{pose.x, pose.y, pose.yaw};
  point.motion = {pose.vx, pose.vy, pose.yaw_rate};
  for (std::size_t i = 0; i < point.covariance.size(); ++i) {
    point.covariance[i] = pose.covariance[i];
  }
  if (frame == Frame::map) point.reset_count = pose.reset_count;
  return point;
}

}  // namespace odomd::tools
