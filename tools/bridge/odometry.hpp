// A pose in ROS terms: REP 103 (axes and units, as in ISO 8855), REP 105 (frames), and the
// covariances of nav_msgs/Odometry. No DDS in here.
#pragma once

#include <array>
#include <cstdint>

#include "estimator/common/estimate.hpp"
#include "tools/bridge/bridge.hpp"

namespace odomd::tools {

/// Variance of axes that a planar pose does not observe (z, roll, pitch): "do not use".
inline constexpr double unobserved_variance = 1e6;

/// 6x6 by rows, over x, y, z and the rotations about x, y and z.
using Covariance6 = std::array<double, 36>;

struct Odometry {
  estimator::Pose2 pose;
  Covariance6 pose_covariance{};  ///< of the pose in the map, along the axes of the frame
  double vx = 0.0;                ///< body frame [m/s]
  double vy = 0.0;
  double yaw_rate = 0.0;           ///< [rad/s]
  Covariance6 twist_covariance{};  ///< body frame
};

[[nodiscard]] Odometry odometry_of(const BridgeSample& sample, PoseFrame frame);

/// The pose of the odometry frame in the map. A jump of the map pose changes it. Composed with the
/// car's pose in the odometry frame, it gives the car's pose in the map.
[[nodiscard]] estimator::Pose2 correction_of(const odom_pose& pose);
[[nodiscard]] estimator::Pose2 correction_between(const estimator::Pose2& map,
                                                  const estimator::Pose2& odom);

/// Rotation about z.
struct PlanarQuaternion {
  double z = 0.0;
  double w = 1.0;
};
[[nodiscard]] PlanarQuaternion quaternion_of(double yaw);

}  // namespace odomd::tools
