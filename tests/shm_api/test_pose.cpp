// Checks of a controller before it uses a pose.
#include <initializer_list>
#include <limits>

#include <odom/odom.hpp>

#include "tests/gtest.hpp"

namespace odomd::shm::testing::test_pose {
namespace {

odom_pose pose_with(double xx, double xy, double yy) {
  odom_pose pose{};
  pose.covariance[0] = xx;
  pose.covariance[1] = xy;
  pose.covariance[3] = yy;
  pose.covariance[2] = pose.covariance[4] = 7.0;  // must not matter: yaw
  pose.covariance[5] = 9.0;
  return pose;
}

TEST(PositionSigma, IsTheAxisOfACovarianceAlongTheAxes) {
  EXPECT_DOUBLE_EQ(odom::position_sigma(pose_with(0.09, 0.0, 0.04)), 0.3);
  EXPECT_DOUBLE_EQ(odom::position_sigma(pose_with(0.04, 0.0, 0.09)), 0.3);
  EXPECT_EQ(odom::position_sigma(pose_with(0.0, 0.0, 0.0)), 0.0);
}

TEST(PositionSigma, IsTheSameHoweverTheCovarianceIsTurned) {
  constexpr double major = 0.5;
  constexpr double minor = 0.1;
  for (const double angle : {0.1, 0.7, 1.5, 2.5, -1.0}) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const double a = major * major;
    const double b = minor * minor;
    EXPECT_NEAR(odom::position_sigma(
                    pose_with(a * c * c + b * s * s, (a - b) * c * s, a * s * s + b * c * c)),
                major, 1e-15);
  }
}

TEST(PositionSigma, IsBelowNoLimitWhereThereIsNoCovariance) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const odom_pose& pose :
       {pose_with(nan, 0.0, 1.0), pose_with(1.0, nan, 1.0), pose_with(-1.0, 0.0, -1.0)})
    EXPECT_FALSE(odom::position_sigma(pose) <= 1e300);
}

TEST(ModeName, IsWhatTheStatusCallsIt) {
  EXPECT_STREQ(odom::mode_name(ODOM_INITIALISING), "initialising");
  EXPECT_STREQ(odom::mode_name(ODOM_DEAD_RECKONING), "dead_reckoning");
  EXPECT_STREQ(odom::mode_name(ODOM_FAULT), "fault");
  EXPECT_STREQ(odom::mode_name(6), "unknown");
  EXPECT_STREQ(odom::mode_name(std::numeric_limits<std::uint32_t>::max()), "unknown");
}

}  // namespace
}  // namespace odomd::shm::testing::test_pose
