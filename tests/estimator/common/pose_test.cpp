// Pose algebra, and motion at a velocity.
#include "estimator/common/pose.hpp"

#include <numbers>

#include "tests/gtest.hpp"

namespace odomd::estimator::pose_test {
namespace {

constexpr double pi = std::numbers::pi;

void expect_near(const Pose2& a, const Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.yaw, b.yaw, tolerance);
}

TEST(Pose, WrapsToTheShorterWay) {
  EXPECT_NEAR(wrap_angle(2.0 * pi + 0.1), 0.1, 1e-15);
  EXPECT_NEAR(wrap_angle(-7.0 * pi - 0.1), pi - 0.1, 1e-14);
  EXPECT_EQ(wrap_angle(-1.0), -1.0);
}

TEST(Pose, DifferenceTurnsTheShorterWay) {
  const std::array<double, 3> nu = difference({1.0, 2.0, 3.0}, {0.5, 3.0, -3.0});
  EXPECT_EQ(nu[0], 0.5);
  EXPECT_EQ(nu[1], -1.0);
  EXPECT_NEAR(nu[2], 6.0 - 2.0 * pi, 1e-15);
}

TEST(Pose, FrameOfUndoesCompose) {
  const Pose2 frame{3.0, -2.0, 2.5};
  const Pose2 local{0.4, 7.0, -1.0};
  expect_near(frame_of(compose(frame, local), local), frame, 1e-14);
}

TEST(Pose, ComposingWithIdentityChangesNoBit) {
  const Pose2 pose{0.1, -0.2, 12.3};
  const Pose2 same = compose({}, pose);
  EXPECT_EQ(same.x, pose.x);
  EXPECT_EQ(same.y, pose.y);
  EXPECT_EQ(same.yaw, pose.yaw);
}

TEST(Pose, MovesOnACircle) {
  // A quarter of a circle of 2 m radius.
  expect_near(moved({}, {1.0, 0.0, 0.5}, pi), {2.0, 2.0, pi / 2.0}, 1e-14);
}

TEST(Pose, MovesSidewaysAsWellAsForward) {
  expect_near(moved({1.0, 1.0, pi / 2.0}, {2.0, 1.0, 0.0}, 0.5), {0.5, 2.0, pi / 2.0}, 1e-15);
}

TEST(Pose, ArcIsSmoothWhereItTurnsStraight) {
  for (const double yaw_rate : {0.99e-4, 1.01e-4, -0.99e-4, -1.01e-4}) {
    const Pose2 arc = moved({}, {1.0, 0.3, yaw_rate}, 1.0);
    EXPECT_NEAR(arc.x, 1.0 - 0.15 * yaw_rate, 1e-8);
    EXPECT_NEAR(arc.y, 0.3 + 0.5 * yaw_rate, 1e-8);
  }
}

TEST(Pose, MovingBackInTimeReturns) {
  const BodyVelocity v{1.2, -0.3, 2.0};
  const Pose2 start{1.0, 2.0, 3.0};
  expect_near(moved(moved(start, v, 0.3), v, -0.3), start, 1e-14);
}

}  // namespace
}  // namespace odomd::estimator::pose_test
