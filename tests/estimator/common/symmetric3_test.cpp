// Covariances of poses: congruences, the test against a gate, and limits.
#include "estimator/common/symmetric3.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

namespace odomd::estimator::symmetric3_test {
namespace {

// A covariance with every entry in use.
constexpr Symmetric3 sample{2.0, 0.3, -0.4, 1.5, 0.2, 0.9};
const Eigen::Matrix3d full = unpacked(sample);

Eigen::Matrix3d diagonal(double a, double b, double c) {
  return Eigen::Vector3d(a, b, c).asDiagonal();
}

TEST(Symmetric3, PacksWhatItUnpacks) {
  EXPECT_EQ(packed(full), sample);
  EXPECT_EQ(full, full.transpose());
}

TEST(Symmetric3, DisplacedMovesTheYawErrorIntoThePosition) {
  // (x, y, ψ) of an error of ψ alone, after 1.9 m along x and 0.7 m along y
  const Eigen::Matrix3d P = displaced(diagonal(0.0, 0.0, 4.0), 1.9, 0.7);
  const Eigen::Vector3d moved(-0.7, 1.9, 1.0);
  EXPECT_LT((P - 4.0 * moved * moved.transpose()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Symmetric3, RotatedTurnsTheAxes) {
  const Eigen::Matrix3d P = rotated(diagonal(4.0, 1.0, 9.0), std::acos(0.6));
  EXPECT_NEAR(P(0, 0), 0.36 * 4.0 + 0.64, 1e-14);
  EXPECT_NEAR(P(1, 1), 0.64 * 4.0 + 0.36, 1e-14);
  EXPECT_NEAR(P(0, 1), 0.48 * 3.0, 1e-14);
  EXPECT_EQ(P(2, 2), 9.0);
}

TEST(Symmetric3, MahalanobisIsThatOfTheInverse) {
  const Eigen::Vector3d nu{0.4, -1.0, 2.0};
  const double expected = nu.dot(full.inverse() * nu);
  EXPECT_NEAR(mahalanobis_squared(full, {0.4, -1.0, 2.0}), expected, 1e-13);
}

TEST(Symmetric3, MahalanobisOfNonsenseFailsEveryGate) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Matrix3d indefinite = unpacked({1.0, 2.0, 0.0, 1.0, 0.0, 1.0});
  EXPECT_EQ(mahalanobis_squared(indefinite, {1.0, 0.0, 0.0}), HUGE_VAL);
  EXPECT_EQ(mahalanobis_squared(diagonal(0.0, 0.0, 0.0), {0.0, 0.0, 0.0}), HUGE_VAL);
  EXPECT_EQ(mahalanobis_squared(full, {nan, 0.0, 0.0}), HUGE_VAL);
  EXPECT_EQ(mahalanobis_squared(full, {1e200, 0.0, 0.0}), HUGE_VAL);
}

TEST(Symmetric3, LimitedKeepsCorrelationsAndDefiniteness) {
  const Eigen::Matrix3d big = unpacked({1e8, 9e4, 0.0, 100.0, 0.0, 1.0});
  const Eigen::Matrix3d p = limited(big, {1e6, 1e6, 0.25});
  EXPECT_DOUBLE_EQ(p(0, 0), 1e6);
  EXPECT_DOUBLE_EQ(p(1, 1), 100.0);
  EXPECT_DOUBLE_EQ(p(2, 2), 0.25);
  EXPECT_NEAR(p(0, 1) / std::sqrt(p(0, 0) * p(1, 1)), 0.9, 1e-12);
  EXPECT_TRUE(is_positive_definite(p));
}

TEST(Symmetric3, SmallCovarianceIsNotLimited) {
  EXPECT_EQ(limited(full, {1e6, 1e6, 9.0}), full);
}

TEST(Symmetric3, KnowsThePositiveDefinite) {
  EXPECT_TRUE(is_positive_definite(full));
  EXPECT_FALSE(is_positive_definite(diagonal(0.0, 0.0, 0.0)));
  EXPECT_FALSE(is_positive_definite(unpacked({1.0, 1.0, 0.0, 1.0, 0.0, 1.0})));
  EXPECT_FALSE(is_positive_definite(diagonal(1.0, 1.0, -1.0)));
  EXPECT_FALSE(is_positive_definite(diagonal(1.0, 1.0, std::nan(""))));
}

}  // namespace
}  // namespace odomd::estimator::symmetric3_test
