// Sensors that are stuck at the end of their range for seconds: their effect on the pose must end
// with the failure.
#include "circle_drive.hpp"
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::railed_sensors_test {
namespace {

using estimator::testing::Arrival;
using estimator::testing::circle;
using estimator::testing::drive_on_a_circle;
using estimator::testing::hand_in;
using estimator::testing::millisecond;
using estimator::testing::period_ns;
using estimator::testing::start_ns;

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
  FullFilter filter{FilterSettings{}};
  filter.set_initial_pose({});
  const std::vector<Arrival> arrivals = drive_with(GetParam());
  std::size_t next = 0;
  std::uint32_t recoveries_when_healthy = 0;
  Estimate e;
  for (int k = 1; k <= 2400; ++k) {
    const std::int64_t now = start_ns + k * period_ns;
    for (; next < arrivals.size() && arrivals[next].arrival_ns <= now; ++next) {
      hand_in(filter, arrivals[next]);
    }
    e = filter.step(now);
    if (k == 1600) {
      recoveries_when_healthy = e.recoveries;
    }
  }
  EXPECT_EQ(e.recoveries, recoveries_when_healthy);
  EXPECT_NEAR(e.v_x, circle.v_x, 0.05);
  EXPECT_NEAR(e.yaw_rate, circle.yaw_rate, 0.05);
  const Pose2 truth = moved({}, circle, static_cast<double>(e.time_ns - start_ns) * 1e-9);
  EXPECT_NEAR(e.map.x, truth.x, 0.03);
  EXPECT_NEAR(e.map.y, truth.y, 0.03);
}

INSTANTIATE_TEST_SUITE_P(Imu, RailedSensors,
                         ::testing::Values(Rail{0.0, 157.0}, Rail{0.0, -157.0}, Rail{0.0, 50.0},
                                           Rail{34.9, 0.0}, Rail{34.9, 157.0}, Rail{-34.9, -157.0},
                                           Rail{8.7, 19.6}));

}  // namespace
}  // namespace odomd::estimator::full::railed_sensors_test
