#include "daemon/core/imu_mounting.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "estimator/common/measurement.hpp"

namespace odomd::daemon::imu_mounting_test {
namespace {

using estimator::Source;

can::Sample sample(Source source, double value) {
  return {.channel = static_cast<std::uint16_t>(source), .value = value};
}

TEST(ImuMounting, TurnsBothAxesIntoTheCars) {
  // The sensor's x axis points to the car's left: an acceleration along x pushes the car to the
  // left.
  std::array samples{sample(Source::yaw_rate, 0.7), sample(Source::accel_y, 2.0),
                     sample(Source::accel_x, 1.0)};
  turn_accelerations(samples, 0.5 * std::numbers::pi);
  EXPECT_EQ(samples[0].value, 0.7);
  EXPECT_NEAR(samples[1].value, 1.0, 1e-12);   // a_y
  EXPECT_NEAR(samples[2].value, -2.0, 1e-12);  // a_x
}

TEST(ImuMounting, KnowsNothingOfAnAxisThatCameAlone) {
  std::array samples{sample(Source::accel_x, 1.0)};
  turn_accelerations(samples, 0.1);
  EXPECT_TRUE(std::isnan(samples[0].value));
}

TEST(ImuMounting, LeavesFramesWithoutAccelerationsAlone) {
  std::array samples{sample(Source::steering, 0.2)};
  turn_accelerations(samples, 0.1);
  EXPECT_EQ(samples[0].value, 0.2);
}

}  // namespace
}  // namespace odomd::daemon::imu_mounting_test
