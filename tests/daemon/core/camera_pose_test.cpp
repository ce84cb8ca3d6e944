#include "daemon/core/camera_pose.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace odomd::daemon::camera_pose_test {
namespace {

estimator::CameraPose facing_north() {
  return {.capture_ns = 1,
          .arrival_ns = 2,
          .x = 10.0,
          .y = 20.0,
          .yaw = std::numbers::pi / 2,
          .sigma_x = 0.01,
          .sigma_y = 0.02,
          .sigma_yaw = 0.1};
}

TEST(CameraPoseAtTheDoor, WithoutALeverArmIsItself) {
  const auto pose = to_centre_of_gravity(facing_north(), {});
  EXPECT_EQ(pose.x, 10.0);
  EXPECT_EQ(pose.y, 20.0);
  EXPECT_EQ(pose.sigma_x, 0.01);
  EXPECT_EQ(pose.sigma_y, 0.02);
  EXPECT_EQ(pose.capture_ns, 1);
  EXPECT_EQ(pose.arrival_ns, 2);
}

TEST(CameraPoseAtTheDoor, MovesBackAlongTheArmInTheBodyFrame) {
  // The reference point is 0.3 m ahead of and 0.1 m left of the centre of gravity; facing north
  // that is 0.3 m north and 0.1 m west of it.
  const auto pose = to_centre_of_gravity(facing_north(), {0.3, 0.1, 0.0});
  EXPECT_NEAR(pose.x, 10.1, 1e-12);
  EXPECT_NEAR(pose.y, 19.7, 1e-12);
}

TEST(CameraPoseAtTheDoor, YawErrorSwingsTheArmAcrossItself) {
  const auto pose = to_centre_of_gravity(facing_north(), {0.3, 0.0, 0.0});
  EXPECT_NEAR(pose.sigma_x, std::hypot(0.01, 0.3 * 0.1), 1e-12);  // across: east-west
  EXPECT_NEAR(pose.sigma_y, 0.02, 1e-12);                         // along: untouched
}

TEST(CameraPoseAtTheDoor, TurnsByTheMountingYawFirst) {
  auto reference = facing_north();
  reference.yaw += 0.2;
  const auto pose = to_centre_of_gravity(reference, {0.3, 0.0, 0.2});
  EXPECT_NEAR(pose.yaw, std::numbers::pi / 2, 1e-12);
  EXPECT_NEAR(pose.x, 10.0, 1e-12);
  EXPECT_NEAR(pose.y, 19.7, 1e-12);
}

}  // namespace
}  // namespace odomd::daemon::camera_pose_test
