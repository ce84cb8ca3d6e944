#include "estimator/integrity/admission.hpp"

#include <limits>

#include "tests/gtest.hpp"

namespace odomd::estimator::admission_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Refusal, BeginsBeyondThePhysicalLimit) {
  for (std::size_t i = 0; i < source_count; ++i) {
    const auto source = static_cast<Source>(i);
    if (source == Source::camera) continue;
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_EQ(refusal({source, 1, sign * physical_limit[i], 0.1}), std::nullopt) << i;
      EXPECT_EQ(refusal({source, 1, sign * 1.001 * physical_limit[i], 0.1}), Verdict::gated) << i;
    }
  }
}

TEST(Refusal, OfNonFiniteNumbers) {
  for (const double value : {nan, infinity, -infinity}) {
    EXPECT_EQ(refusal({Source::yaw_rate, 1, value, 0.1}), Verdict::non_finite);
    EXPECT_EQ(refusal({Source::yaw_rate, 1, 0.0, value}), Verdict::non_finite);
  }
  EXPECT_EQ(refusal({Source::yaw_rate, 1, 0.0, -0.1}), Verdict::non_finite);
  // The configured sigma applies.
  EXPECT_EQ(refusal({Source::yaw_rate, 1, 0.0, 0.0}), std::nullopt);
}

TEST(Refusal, OfSourcesThatAreNotSignals) {
  EXPECT_EQ(refusal({Source::camera, 1, 0.0, 0.1}), Verdict::source_off);
  EXPECT_EQ(refusal({Source::count, 1, 0.0, 0.1}), Verdict::source_off);
  EXPECT_EQ(refusal({static_cast<Source>(255), 1, nan, 0.1}), Verdict::source_off);
}

TEST(IsPossible, AcceptsPosesThatDoublesResolve) {
  EXPECT_TRUE(is_possible(Pose2{}));
  EXPECT_TRUE(is_possible(Pose2{1e8, -1e8, 1e3}));
  for (double Pose2::*const number : {&Pose2::x, &Pose2::y, &Pose2::yaw}) {
    for (const double value : {nan, infinity, -infinity}) {
      Pose2 pose;
      pose.*number = value;
      EXPECT_FALSE(is_possible(pose));
    }
  }
  EXPECT_FALSE(is_possible(Pose2{1.1e8, 0.0, 0.0}));
  EXPECT_FALSE(is_possible(Pose2{0.0, -1.1e8, 0.0}));
  EXPECT_FALSE(is_possible(Pose2{0.0, 0.0, 1.1e6}));
}

TEST(IsUsable, ChecksEveryNumberOfACameraPose) {
  const CameraPose pose{1, 2, 0.5, -0.5, 3.0, 0.01, 0.02, 0.03};
  EXPECT_TRUE(is_usable(pose));
  const auto expect_refused = [&](double CameraPose::*number,
                                  std::initializer_list<double> values) {
    for (const double value : values) {
      CameraPose broken = pose;
      broken.*number = value;
      EXPECT_FALSE(is_usable(broken));
    }
  };
  for (const auto number : {&CameraPose::x, &CameraPose::y, &CameraPose::yaw})
    expect_refused(number, {nan, infinity, -infinity});
  for (const auto sigma : {&CameraPose::sigma_x, &CameraPose::sigma_y, &CameraPose::sigma_yaw})
    expect_refused(sigma, {nan, infinity, -infinity, 0.0, -0.01});
}

}  // namespace
}  // namespace odomd::estimator::admission_test
