// Start of the filter: from a camera pose, at rest, or from a predecessor.
#include <cstring>
#include <optional>

#include "circle_drive.hpp"
#include "estimator/full_filter.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::begin_test {
namespace {

TEST(Begin, ACameraPoseFromBeforeTheFirstTickInitialises) {
  FilterSettings settings;
  settings.initialise_from_camera = true;
  FullFilter filter(settings);
  const std::int64_t tick = start_ns + 100 * millisecond;
  for (std::int64_t t = start_ns; t < tick; t += period_ns) {
    (void)filter.add(Measurement{Source::wheel_rear, t, 2.0, 0.01});
    (void)filter.add(Measurement{Source::yaw_rate, t, 0.0, 0.01});
    (void)filter.add(Measurement{Source::steering, t, 0.0, 0.001});
  }
  const std::int64_t captured = tick - 50 * millisecond;
  EXPECT_EQ(filter.add(CameraPose{captured, tick, 1.0, 2.0, 0.5, 0.008, 0.008, 0.009}),
            std::nullopt);
  const Estimate e = filter.step(tick);
  EXPECT_TRUE(e.initialised);
  EXPECT_EQ(e.reset_count, 1U);
  // The present position, not the one at the capture time.
  EXPECT_NEAR(e.map.x, 1.0 + 0.1 * std::cos(0.5), 0.01);
  EXPECT_NEAR(e.map.y, 2.0 + 0.1 * std::sin(0.5), 0.01);
  EXPECT_NEAR(e.map.yaw, 0.5, 0.01);
  EXPECT_EQ(e.odom.x, e.map.x);
  EXPECT_EQ(e.camera_ns, captured);
}

TEST(Begin, ItsFirstPoseIsTheSameInBothFrames) {
  // Samples may wait a whole window for the first tick, and the car moves far in that time.
  FullFilter filter({});
  filter.set_initial_pose({1.0, 2.0, 0.5});
  const std::int64_t tick = start_ns + 240 * millisecond;
  for (std::int64_t t = start_ns; t < tick; t += 2 * millisecond + 1) {
    (void)filter.add(Measurement{Source::wheel_rear, t, 2.0, 0.01});
    (void)filter.add(Measurement{Source::yaw_rate, t, 1.0, 0.01});
    (void)filter.add(Measurement{Source::steering, t, 0.13, 0.001});
  }
  const Estimate first = filter.step(tick);
  ASSERT_TRUE(first.initialised);
  EXPECT_EQ(first.reset_count, 1U);
  EXPECT_GT(std::hypot(first.map.x - 1.0, first.map.y - 2.0), 0.4);
  EXPECT_EQ(numbers_of(first.odom), numbers_of(first.map));

  // From there on the odometry pose moves at the car's speed.
  const Estimate second = filter.step(tick + period_ns);
  EXPECT_NEAR(std::hypot(second.odom.x - first.odom.x, second.odom.y - first.odom.y), 0.01, 1e-3);
}

TEST(Begin, ALateFirstWheelSampleStartsBothFramesTogether) {
  FullFilter filter = started();
  for (std::int64_t k = 1; k <= 60; ++k)
    EXPECT_FALSE(filter.step(start_ns + k * period_ns).initialised);
  const std::int64_t now = start_ns + 61 * period_ns;
  for (std::int64_t age = 200; age > 0; age -= 10)
    (void)filter.add(Measurement{Source::wheel_rear, now - age * millisecond, 2.0, 0.01});
  const Estimate first = filter.step(now);
  ASSERT_TRUE(first.initialised);
  EXPECT_NEAR(first.map.x, 0.4, 0.03);
  EXPECT_EQ(first.odom.x, first.map.x);
  EXPECT_EQ(first.odom.y, first.map.y);
}

TEST(Begin, ResumesWithTheCalibrationOfItsPredecessor) {
  Estimate predecessor = run(drive_on_a_circle(2'000 * millisecond), 400).back();
  Calibration& learnt = predecessor.calibration;
  learnt.value = {0.011, 1.004, 0.12, -0.08, 1.013, 0.007, 0.93};
  learnt.sigma = {0.001, 0.002, 0.01, 0.01, 0.001, 0.001, 0.03};

  FullFilter filter({});
  ASSERT_TRUE(filter.resume(predecessor, 0.3));
  const Calibration& resumed = filter.step(start_ns).calibration;
  std::uint64_t every = 0;
  for (std::size_t i = 0; i < calibration_count; ++i) {
    if (learnt.sigma[i] == 0.0) continue;
    every |= std::uint64_t{1} << i;
    EXPECT_NEAR(resumed.value[i], learnt.value[i], 1e-12) << i;
    EXPECT_GE(resumed.sigma[i], learnt.sigma[i]) << i;
    // The road's slope may have changed in a tick, which counts as a bias of the accelerometers.
    const double slope = i == 2 || i == 3 ? 0.015 * std::sqrt(circle.v_x * 0.005) * gravity : 0.0;
    EXPECT_LT(resumed.sigma[i], 1.1 * std::hypot(learnt.sigma[i], slope)) << i;
  }
  EXPECT_EQ(resumed.valid, every);
}

TEST(Begin, ResumesInTheMiddleOfADriveAsWellAsAtItsBegin) {
  const Estimate predecessor = run(drive_on_a_circle(500 * millisecond), 100).back();
  FullFilter filter = started();
  const std::vector<Arrival> arrivals = drive_on_a_circle(1'000 * millisecond);
  (void)run(filter, arrivals, 100);
  ASSERT_TRUE(filter.resume(predecessor, 0.0));
  const Estimate e = filter.step(start_ns + 101 * period_ns);
  EXPECT_NEAR(e.map.x, predecessor.map.x, 0.02);
  EXPECT_NEAR(e.map.y, predecessor.map.y, 0.02);
  EXPECT_EQ(e.reset_count, predecessor.reset_count + 1);
  EXPECT_LT(std::sqrt(e.covariance[0]), 0.05);
}

TEST(Begin, ResumesWithoutCalibrationsThatMeanNothing) {
  Estimate predecessor = run(drive_on_a_circle(500 * millisecond), 100).back();
  predecessor.calibration.value.fill(std::nan(""));
  predecessor.calibration.sigma = {0.001, 0.0, -1.0, 1e9, std::nan(""), 0.001, 0.0};
  FullFilter filter({});
  ASSERT_TRUE(filter.resume(predecessor, 0.3));
  const Estimate e = filter.step(start_ns);
  EXPECT_EQ(e.calibration.value, FullFilter({}).step(start_ns).calibration.value);
  EXPECT_EQ(e.calibration.valid, 0U);
}

TEST(Begin, ItsBytesAreAllThereIs) {
  // A recording stores the filter's bytes, and a replay resumes from them.
  const std::vector<Arrival> arrivals = drive_on_a_circle(1'000 * millisecond);
  FullFilter filter = started();
  (void)run(filter, arrivals, 100);
  FullFilter other({});
  static_assert(std::is_trivially_destructible_v<FullFilter>);
  std::memcpy(static_cast<void*>(&other), static_cast<const void*>(&filter), sizeof filter);
  const std::vector<Estimate> expected = run(filter, arrivals, 200, 101);
  const std::vector<Estimate> resumed = run(other, arrivals, 200, 101);
  for (std::size_t i = 0; i < expected.size(); ++i) expect_same_frames(resumed[i], expected[i]);
}

}  // namespace
}  // namespace odomd::estimator::testing::begin_test
