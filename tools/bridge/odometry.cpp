#include "tools/bridge/odometry.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>

#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

/// The symmetric covariance of x, y and yaw, from the rows of its upper triangle.
Eigen::Matrix3d covariance_of(const double* P) {
  Eigen::Matrix3d all;
  all << P[0], P[1], P[2], P[1], P[3], P[4], P[2], P[4], P[5];
  return all;
}

/// Puts the covariance of x, y and yaw into that of all six axes.
Covariance6 placed(const Eigen::Matrix3d& P) {
  constexpr std::array<std::size_t, 3> axes{0, 1, 5};
  Covariance6 all{};
  for (std::size_t i = 0; i < 6; ++i) all[i * 7] = unobserved_variance;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 3; ++j)
      all[axes[static_cast<std::size_t>(i)] * 6 + axes[static_cast<std::size_t>(j)]] = P(i, j);
  return all;
}

}  // namespace

estimator::Pose2 correction_between(const estimator::Pose2& map, const estimator::Pose2& odom) {
  return compose(map, inverse(odom));
}

estimator::Pose2 correction_of(const odom_pose& pose) {
  return correction_between({pose.x, pose.y, pose.yaw}, {pose.odom_x, pose.odom_y, pose.odom_yaw});
}

PlanarQuaternion quaternion_of(double yaw) {
  // The yaw is unwrapped. Without remainder(), every whole turn would change the quaternion's sign.
  const double half = 0.5 * std::remainder(yaw, 2.0 * 3.14159265358979323846);
  return {std::sin(half), std::cos(half)};
}

Odometry odometry_of(const BridgeSample& sample, PoseFrame frame) {
  const odom_pose& pose = sample.pose;
  const Eigen::Matrix3d in_map = covariance_of(pose.covariance);
  Odometry odometry;
  if (frame == PoseFrame::map) {
    odometry.pose = {pose.x, pose.y, pose.yaw};
    odometry.pose_covariance = placed(in_map);
  } else {
    odometry.pose = {pose.odom_x, pose.odom_y, pose.odom_yaw};
    const Eigen::Matrix3d J =
        Eigen::AngleAxisd(pose.odom_yaw - pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    odometry.pose_covariance = placed(J * in_map * J.transpose());
  }
  odometry.vx = pose.vx;
  odometry.vy = pose.vy;
  odometry.yaw_rate = pose.yaw_rate;
  // V begins with the nine covariances between pose and velocities.
  odometry.twist_covariance = placed(covariance_of(sample.details.velocity_covariance + 9));
  return odometry;
}

}  // namespace odomd::tools
