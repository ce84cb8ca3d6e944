#include "tools/bridge/odometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tools/math/se2.hpp"

namespace odomd::tools::odometry_test {
namespace {

BridgeSample sample() {
  BridgeSample sample;
  odom_pose& pose = sample.pose;
  pose.x = 10.0;
  pose.y = -4.0;
  pose.yaw = 2.0;
  pose.odom_x = 9.0;
  pose.odom_y = -5.5;
  pose.odom_yaw = 2.0 - std::numbers::pi / 2.0;
  pose.vx = 3.0;
  pose.vy = -0.25;
  pose.yaw_rate = 0.5;
  const double covariance[]{0.04, 0.01, 0.002, 0.09, -0.003, 0.0016};
  std::copy(std::begin(covariance), std::end(covariance), pose.covariance);
  for (int i = 0; i < 15; ++i) sample.details.velocity_covariance[i] = 100.0 + i;
  return sample;
}

double at(const Covariance6& P, std::size_t row, std::size_t column) {
  return P[row * 6 + column];
}

void expect_planar(const Covariance6& P) {
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      EXPECT_EQ(at(P, i, j), at(P, j, i));
      const bool observed = (i < 2 || i == 5) && (j < 2 || j == 5);
      if (!observed) {
        EXPECT_EQ(at(P, i, j), i == j ? 1e6 : 0.0) << i << ',' << j;
      }
    }
  }
}

TEST(Odometry, InTheMapHasTheBlocksWhereRosLooksForThem) {
  const Odometry odometry = odometry_of(sample(), PoseFrame::map);
  EXPECT_EQ(odometry.pose.x, 10.0);
  EXPECT_EQ(odometry.pose.yaw, 2.0);
  EXPECT_EQ(odometry.vy, -0.25);
  const Covariance6& P = odometry.pose_covariance;
  expect_planar(P);
  EXPECT_EQ(at(P, 0, 0), 0.04);
  EXPECT_EQ(at(P, 0, 1), 0.01);
  EXPECT_EQ(at(P, 0, 5), 0.002);
  EXPECT_EQ(at(P, 1, 1), 0.09);
  EXPECT_EQ(at(P, 1, 5), -0.003);
  EXPECT_EQ(at(P, 5, 5), 0.0016);
  const Covariance6& V = odometry.twist_covariance;
  expect_planar(V);
  EXPECT_EQ(at(V, 0, 0), 109.0);
  EXPECT_EQ(at(V, 0, 1), 110.0);
  EXPECT_EQ(at(V, 0, 5), 111.0);
  EXPECT_EQ(at(V, 1, 1), 112.0);
  EXPECT_EQ(at(V, 1, 5), 113.0);
  EXPECT_EQ(at(V, 5, 5), 114.0);
}

TEST(Odometry, InTheOdometryFrameHasTheCovarianceTurnedToItsAxes) {
  // The odometry frame is turned by +90 degrees in the map: its x is the map's y, its y the
  // map's -x.
  const Odometry odometry = odometry_of(sample(), PoseFrame::odom);
  EXPECT_EQ(odometry.pose.x, 9.0);
  EXPECT_EQ(odometry.pose.y, -5.5);
  const Covariance6& P = odometry.pose_covariance;
  expect_planar(P);
  EXPECT_NEAR(at(P, 0, 0), 0.09, 1e-15);
  EXPECT_NEAR(at(P, 1, 1), 0.04, 1e-15);
  EXPECT_NEAR(at(P, 0, 1), -0.01, 1e-15);
  EXPECT_NEAR(at(P, 0, 5), -0.003, 1e-15);
  EXPECT_NEAR(at(P, 1, 5), -0.002, 1e-15);
  EXPECT_NEAR(at(P, 5, 5), 0.0016, 1e-15);
}

TEST(Odometry, CorrectionAndOdometryPoseMakeTheMapPose) {
  const odom_pose pose = sample().pose;
  const estimator::Pose2 map =
      compose(correction_of(pose), {pose.odom_x, pose.odom_y, pose.odom_yaw});
  EXPECT_NEAR(map.x, pose.x, 1e-12);
  EXPECT_NEAR(map.y, pose.y, 1e-12);
  EXPECT_NEAR(map.yaw, pose.yaw, 1e-12);
}

TEST(Odometry, QuaternionOfAnUnwrappedYawHasOneSign) {
  const double turn = 2.0 * std::numbers::pi;
  const PlanarQuaternion once = quaternion_of(0.7);
  const PlanarQuaternion later = quaternion_of(0.7 + 5.0 * turn);
  EXPECT_NEAR(once.z, std::sin(0.35), 1e-15);
  EXPECT_NEAR(once.w, std::cos(0.35), 1e-15);
  EXPECT_NEAR(later.z, once.z, 1e-12);
  EXPECT_NEAR(later.w, once.w, 1e-12);
  EXPECT_NEAR(std::hypot(later.z, later.w), 1.0, 1e-15);
}

}  // namespace
}  // namespace odomd::tools::odometry_test
