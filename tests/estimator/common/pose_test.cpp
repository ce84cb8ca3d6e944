// Pose algebra and motion at a velocity; packed covariances compared with full matrices.
#include "estimator/common/pose.hpp"

#include <Eigen/Dense>
#include <limits>
#include <numbers>

#include "estimator/common/symmetric3.hpp"
#include "tests/estimator/drive.hpp"

namespace odomd::estimator::testing::pose_test {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Pose, WrapsAngles) {
  EXPECT_NEAR(wrap_angle(2.0 * pi + 0.1), 0.1, 1e-15);
  EXPECT_NEAR(wrap_angle(-7.0 * pi - 0.1), pi - 0.1, 1e-14);
  EXPECT_EQ(wrap_angle(-1.0), -1.0);
}

TEST(Pose, DifferenceWrapsTheYaw) {
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

// A covariance without zero entries.
constexpr Symmetric3 sample{2.0, 0.3, -0.4, 1.5, 0.2, 0.9};

TEST(Symmetric3, PacksWhatItUnpacks) {
  EXPECT_EQ(unpacked(sample),
            (Eigen::Matrix3d{{2.0, 0.3, -0.4}, {0.3, 1.5, 0.2}, {-0.4, 0.2, 0.9}}));
  EXPECT_EQ(packed(unpacked(sample)), sample);
}

TEST(Symmetric3, RotatedIsTheCongruence) {
  const double c = std::cos(0.8);
  const double s = std::sin(0.8);
  const Eigen::Matrix3d R{{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}};
  const Eigen::Matrix3d expected = R * unpacked(sample) * R.transpose();
  EXPECT_LT((unpacked(rotated(sample, c, s)) - expected).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Symmetric3, DisplacementMapsHeadingErrorToPositionError) {
  EXPECT_EQ(displacement(1.9, 0.7),
            (Eigen::Matrix3d{{1.0, 0.0, -0.7}, {0.0, 1.0, 1.9}, {0.0, 0.0, 1.0}}));
}

TEST(Symmetric3, MahalanobisUsesTheInverse) {
  const Eigen::Vector3d nu{0.4, -1.0, 2.0};
  const double expected = nu.dot(unpacked(sample).inverse() * nu);
  EXPECT_NEAR(mahalanobis_squared(unpacked(sample), {0.4, -1.0, 2.0}), expected, 1e-13);
}

TEST(Symmetric3, MahalanobisOfInvalidInputFailsEveryGate) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Matrix3d indefinite = unpacked({1.0, 2.0, 0.0, 1.0, 0.0, 1.0});
  EXPECT_EQ(mahalanobis_squared(indefinite, {1.0, 0.0, 0.0}), HUGE_VAL);
  EXPECT_EQ(mahalanobis_squared(unpacked({}), {0.0, 0.0, 0.0}), HUGE_VAL);
  EXPECT_EQ(mahalanobis_squared(unpacked(sample), {nan, 0.0, 0.0}), HUGE_VAL);
  EXPECT_EQ(mahalanobis_squared(unpacked(sample), {1e200, 0.0, 0.0}), HUGE_VAL);
}

TEST(Symmetric3, LimitedKeepsCorrelationsAndDefiniteness) {
  Eigen::Matrix3d big = unpacked({1e8, 9e4, 0.0, 100.0, 0.0, 1.0});
  limit(big, Eigen::Vector3d(1e3, 1e3, 0.5));
  const Symmetric3 p = packed(big);
  EXPECT_DOUBLE_EQ(p[0], 1e6);
  EXPECT_DOUBLE_EQ(p[3], 100.0);
  EXPECT_DOUBLE_EQ(p[5], 0.25);
  EXPECT_NEAR(p[1] / std::sqrt(p[0] * p[3]), 0.9, 1e-12);
  EXPECT_TRUE(is_positive_definite(p));
}

TEST(Symmetric3, RecognisesPositiveDefiniteMatrices) {
  EXPECT_TRUE(is_positive_definite(sample));
  EXPECT_FALSE(is_positive_definite(Symmetric3{}));
  EXPECT_FALSE(is_positive_definite(Symmetric3{1.0, 1.0, 0.0, 1.0, 0.0, 1.0}));
  EXPECT_FALSE(is_positive_definite(Symmetric3{1.0, 0.0, 0.0, 1.0, 0.0, -1.0}));
}

}  // namespace
}  // namespace odomd::estimator::testing::pose_test
