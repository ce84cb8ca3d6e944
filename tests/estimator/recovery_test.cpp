// An invalid state is counted, never published, and restarted from the last pose.
#include <limits>

#include "circle_drive.hpp"
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::recovery_test {
namespace {

TEST(Recovery, KeepsThePoseThatWasGivenAndFiniteNumbers) {
  // A mass that no configuration allows makes every step of the model NaN.
  FilterSettings settings;
  settings.vehicle.mass = std::numeric_limits<double>::quiet_NaN();
  FullFilter filter(settings);
  const Pose2 given{12.0, -3.0, 0.7};
  filter.set_initial_pose(given);
  auto arrivals = drive_on_a_circle(500 * millisecond);
  std::erase_if(arrivals, [](const auto& arrival) { return arrival.camera.has_value(); });
  const std::vector<Estimate> estimates = run(filter, arrivals, 101);
  for (const Estimate& e : estimates) {
    // The pose continues from there at 2 m/s.
    EXPECT_THAT(e.map, PoseNear(given, 0.1)) << e.time_ns;
    EXPECT_THAT(e.odom, PoseNear(given, 0.1)) << e.time_ns;
    ASSERT_TRUE(is_finite(BodyVelocity{e.v_x, e.v_y, e.yaw_rate})) << e.time_ns;
    ASSERT_TRUE(is_finite(e.covariance)) << e.time_ns;
  }
  EXPECT_GT(std::ranges::count_if(estimates, &Estimate::initialised), 90);
  EXPECT_GT(estimates.back().recoveries, 90U);
  EXPECT_GT(estimates.back().covariance[0], 10.0 * estimates[5].covariance[0]);
}

}  // namespace
}  // namespace odomd::estimator::testing::recovery_test
