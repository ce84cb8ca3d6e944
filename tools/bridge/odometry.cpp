#include "tools/bridge/odometry.hpp"

#include <cmath>
#include <cstddef>

#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

// Symmetric: xx, xy, xyaw, yy, yyaw, yawyaw.
using Covariance3 = std::array<double, 6>;

Covariance6 placed(const Covariance3& P) {
  constexpr std::size_t x = 0;
  constexpr std::size_t y = 1;
  constexpr std::size_t yaw = 5;
  Covariance6 all{};
  for (std::size_t i = 0; i < 6; ++i) all[i * 6 + i] = unobserved_variance;
  const auto set = [&all](std::size_t i, std::size_t j, double value) {
    all[i * 6 + j] = value;
    all[j * 6 + i] = value;
  };
  set(x, x, P[0]);
  set(x, y, P[1]);
  set(x, yaw, P[2]);
  set(y, y, P[3]);
  set(y, yaw, P[4]);
  set(yaw, yaw, P[5]);
  return all;
}

// J·P·Jᵀ with J = diag(R(angle), 1)
Covariance3 turned(const Covariance3& P, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const auto [xx, xy, xyaw, yy, yyaw, yawyaw] = P;
  return {c * c * xx - 2.0 * c * s * xy + s * s * yy,
          c * s * (xx - yy) + (c * c - s * s) * xy,
          c * xyaw - s * yyaw,
          s * s * xx + 2.0 * c * s * xy + c * c * yy,
          s * xyaw + c * yyaw,
          yawyaw};
}

}  // namespace

estimator::Pose2 correction_between(const estimator::Pose2& map, const estimator::Pose2& odom) {
  return compose(map, inverse(odom));
}

estimator::Pose2 correction_of(const odom_pose& pose) {
  return correction_between({pose.x, pose.y, pose.yaw}, {pose.odom_x, pose.odom_y, pose.odom_yaw});
}

PlanarQuaternion quaternion_of(double yaw) {
  // The yaw is unwrapped, so half of it may have any size; keep the quaternion's sign consistent.
  const double half = 0.5 * std::remainder(yaw, 2.0 * 3.14159265358979323846);
  return {std::sin(half), std::cos(half)};
}

Odometry odometry_of(const BridgeSample& sample, PoseFrame frame) {
  const odom_pose& pose = sample.pose;
  const auto& P = pose.covariance;
  const Covariance3 in_map{P[0], P[1], P[2], P[3], P[4], P[5]};
  Odometry odometry;
  if (frame == PoseFrame::map) {
    odometry.pose = {pose.x, pose.y, pose.yaw};
    odometry.pose_covariance = placed(in_map);
  } else {
    odometry.pose = {pose.odom_x, pose.odom_y, pose.odom_yaw};
    odometry.pose_covariance = placed(turned(in_map, pose.odom_yaw - pose.yaw));
  }
  odometry.vx = pose.vx;
  odometry.vy = pose.vy;
  odometry.yaw_rate = pose.yaw_rate;
  // V begins with the nine covariances between pose and velocities.
  const auto& V = sample.details.velocity_covariance;
  odometry.twist_covariance = placed({V[9], V[10], V[11], V[12], V[13], V[14]});
  return odometry;
}

}  // namespace odomd::tools
