// Pose algebra, and motion at a velocity.
#include "estimator/common/pose.hpp"

#include <numbers>

#include "tests/estimator/drive.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::pose_test {
namespace {

constexpr double pi = std::numbers::pi;

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

TEST(Pose, MovesOnACircle) {
  // A quarter of a circle of 2 m radius.
  EXPECT_THAT(moved({}, {1.0, 0.0, 0.5}, pi), PoseNear({2.0, 2.0, pi / 2.0}, 1e-14));
}

TEST(Pose, MovesSidewaysAsWellAsForward) {
  EXPECT_THAT(moved({1.0, 1.0, pi / 2.0}, {2.0, 1.0, 0.0}, 0.5),
              PoseNear({0.5, 2.0, pi / 2.0}, 1e-15));
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
  EXPECT_THAT(moved(moved(start, v, 0.3), v, -0.3), PoseNear(start, 1e-14));
}

}  // namespace
}  // namespace odomd::estimator::testing::pose_test
