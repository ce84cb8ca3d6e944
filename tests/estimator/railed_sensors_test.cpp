// Sensors that are stuck at the end of their range for seconds: their effect on the pose must end
// with the failure.
#include "circle_drive.hpp"
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::railed_sensors_test {
namespace {

struct Rail {
  double gyro;   ///< 0: healthy
  double accel;  ///< likewise, both axes
};

/// 12 s on a circle, the rail from 4 s to 7 s.
std::vector<Arrival> drive_with(const Rail& rail) {
  std::vector<Arrival> arrivals = drive_on_a_circle(12'000 * millisecond);
  for (Arrival& arrival : arrivals) {
    if (!arrival.signal || arrival.signal->time_ns < start_ns + 4'000 * millisecond ||
        arrival.signal->time_ns > start_ns + 7'000 * millisecond) {
      continue;
    }
    const Source source = arrival.signal->source;
    if (source == Source::yaw_rate && rail.gyro != 0.0) {
      arrival.signal->value = rail.gyro;
    } else if ((source == Source::accel_x || source == Source::accel_y) && rail.accel != 0.0) {
      arrival.signal->value = rail.accel;
    }
  }
  return arrivals;
}

class RailedSensors : public ::testing::TestWithParam<Rail> {};

TEST_P(RailedSensors, LeaveNothingBehind) {
  FullFilter filter = started();
  const std::vector<Estimate> estimates = run(filter, drive_with(GetParam()), 2400);
  const Estimate& e = estimates.back();
  EXPECT_EQ(e.recoveries, estimates[1599].recoveries) << "none once it is healthy";
  EXPECT_NEAR(e.v_x, circle.v_x, 0.05);
  EXPECT_NEAR(e.yaw_rate, circle.yaw_rate, 0.05);
  const Pose2 truth = on_circle(e.time_ns);
  EXPECT_NEAR(e.map.x, truth.x, 0.03);
  EXPECT_NEAR(e.map.y, truth.y, 0.03);
}

INSTANTIATE_TEST_SUITE_P(Imu, RailedSensors,
                         ::testing::Values(Rail{0.0, 157.0}, Rail{0.0, -157.0}, Rail{0.0, 50.0},
                                           Rail{34.9, 0.0}, Rail{34.9, 157.0}, Rail{-34.9, -157.0},
                                           Rail{8.7, 19.6}));

}  // namespace
}  // namespace odomd::estimator::testing::railed_sensors_test
