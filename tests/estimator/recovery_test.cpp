// An invalid state is counted, never published, and restarted from the last pose.
#include <limits>

#include "circle_drive.hpp"
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::recovery_test {
namespace {

using estimator::testing::drive_on_a_circle;
using estimator::testing::hand_in;
using estimator::testing::millisecond;
using estimator::testing::period_ns;
using estimator::testing::start_ns;

/// A mass that no configuration allows makes every step of the model NaN.
FullFilter that_always_fails(const Pose2& pose) {
  FilterSettings settings;
  settings.vehicle.mass = std::numeric_limits<double>::quiet_NaN();
  FullFilter filter(settings);
  filter.set_initial_pose(pose);
  return filter;
}

TEST(Recovery, KeepsThePoseThatWasGivenAndFiniteNumbers) {
  const Pose2 given{12.0, -3.0, 0.7};
  FullFilter filter = that_always_fails(given);
  const auto arrivals = drive_on_a_circle(500 * millisecond);
  std::size_t next = 0;
  std::uint32_t published = 0;
  for (int k = 1; k <= 100; ++k) {
    const std::int64_t now = start_ns + k * period_ns;
    for (; next < arrivals.size() && arrivals[next].arrival_ns <= now; ++next) {
      if (arrivals[next].signal) {
        hand_in(filter, arrivals[next]);
      }
    }
    const Estimate e = filter.step(now);
    published += e.initialised ? 1 : 0;
    for (const Pose2& pose : {e.map, e.odom}) {
      // The pose continues from there at 2 m/s.
      EXPECT_NEAR(pose.x, given.x, 0.1) << k;
      EXPECT_NEAR(pose.y, given.y, 0.1) << k;
      EXPECT_NEAR(pose.yaw, given.yaw, 0.1) << k;
    }
    for (const double number : {e.v_x, e.v_y, e.yaw_rate}) {
      ASSERT_TRUE(std::isfinite(number)) << k;
    }
    for (const double number : e.covariance) {
      ASSERT_TRUE(std::isfinite(number)) << k;
    }
  }
  EXPECT_GT(published, 90U);
  EXPECT_GT(filter.step(start_ns + 101 * period_ns).recoveries, 90U);
}

}  // namespace
}  // namespace odomd::estimator::full::recovery_test
