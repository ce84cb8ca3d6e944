// Compares the paper's filter with its author's own, and tests when it stops.
#include "estimator/baselines/motion.hpp"
#include "estimator/filter.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/estimator/golden.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::paper_filter_test {
namespace {

constexpr double tolerance = 1e-9;

TEST(PaperFilter, AgreesWithTheAuthorsFilterFromAnyPose) {
  const Pose2 initial{3.0, -4.0, 1.2};
  Drive drive = start(Model::paper);
  Drive elsewhere = start(Model::paper, {}, initial);
  std::size_t step = 0;
  for (const auto& [steering, accel_x, yaw_rate, speed, expected] : read_golden()) {
    const testing::Samples samples{speed, steering, yaw_rate, accel_x};
    const Estimate e = drive.tick(samples);
    ASSERT_TRUE(e.initialised);
    const std::array<double, 6> in_map{e.v_x, e.v_y, e.yaw_rate, e.map.x, e.map.y, e.map.yaw};
    for (std::size_t i = 0; i < in_map.size(); ++i) {
      ASSERT_NEAR(in_map[i], expected[i], tolerance) << "column " << i << ", step " << step;
    }
    ASSERT_EQ(testing::numbers_of(e.map), testing::numbers_of(e.odom));
    const Pose2 moved = compose(initial, {expected[3], expected[4], expected[5]});
    ASSERT_THAT(elsewhere.tick(samples).map, testing::PoseNear(moved, 10.0 * tolerance)) << step;
    ++step;
  }
  EXPECT_EQ(step, 4000U);
}

TEST(PaperFilter, IgnoresTheTimesOfItsSamples) {
  Drive fresh = start(Model::paper);
  Drive late = start(Model::paper);
  for (int i = 0; i < 1000; ++i) {
    const double speed = 1.0 + 0.001 * i;
    fresh.tick({.speed = speed, .steering = 0.1, .yaw_rate = 0.4});
    const std::int64_t past = late.now_ns - 300'000'000;
    add(late.filter, Measurement{Source::wheel_rear, past, speed, 0.0});
    add(late.filter, Measurement{Source::steering, past, 0.1, 0.0});
    add(late.filter, Measurement{Source::yaw_rate, past, 0.4, 0.0});
    late.tick({});
    ASSERT_EQ(fresh.last.map.x, late.last.map.x);
  }
}

TEST(PaperFilter, UsesTheAccelerationButNotTheLateralOne) {
  Drive drive = start(Model::paper);
  EXPECT_EQ(add(drive.filter, Measurement{Source::accel_x, 1, 1.0, 0.1}), Verdict::fused);
  EXPECT_EQ(add(drive.filter, Measurement{Source::accel_y, 1, 2.0, 0.1}), Verdict::source_off);
  EXPECT_EQ(add(drive.filter, Measurement{Source::accel_y, 1, 2.0, 0.1}), Verdict::duplicate);
  const Estimate e = drive.tick({.speed = 1.0});
  EXPECT_EQ(e.accel_x, 1.0);
  EXPECT_EQ(e.accel_y, 2.0);
}

TEST(PaperFilter, DerivativesAreThoseOfTheContinuousModel) {
  Drive drive = start(Model::paper);
  const Estimate e =
      drive.ticks(300, {.speed = 1.5, .steering = 0.15, .yaw_rate = 0.8, .accel_x = 0.4});
  const BodyVelocity rate = dynamic_rate(Vehicle{}, {e.v_x, e.v_y, e.yaw_rate}, 0.15, 0.4, 0.185);
  EXPECT_DOUBLE_EQ(e.v_x_dot, rate.v_x);
  EXPECT_DOUBLE_EQ(e.v_y_dot, rate.v_y);
  EXPECT_DOUBLE_EQ(e.yaw_accel, rate.yaw_rate);
  EXPECT_DOUBLE_EQ(e.v_x_dot, 0.4 + e.v_y * e.yaw_rate);
}

TEST(PaperFilter, StopsForGoodWhenItReverses) {
  Drive drive = start(Model::paper);
  drive.ticks(200, {.speed = 0.5, .steering = 0.3, .yaw_rate = 0.6});
  Estimate before = drive.last;
  int ticks = 0;
  while (!drive.last.model_fault && ticks < 400) {
    before = drive.last;
    ASSERT_GE(before.v_x, -0.05);
    drive.tick({.speed = -0.5, .steering = 0.3, .yaw_rate = -0.6});
    ++ticks;
  }
  ASSERT_TRUE(drive.last.model_fault);
  EXPECT_EQ(drive.last.mode, Mode::fault);
  const auto expect_frozen = [&](const Estimate& e) {
    EXPECT_EQ(e.map.x, before.map.x);
    EXPECT_EQ(e.map.y, before.map.y);
    EXPECT_EQ(e.map.yaw, before.map.yaw);
    EXPECT_EQ(e.v_x, 0.0);
    EXPECT_EQ(e.v_y, 0.0);
    EXPECT_EQ(e.yaw_rate, 0.0);
    EXPECT_EQ(e.v_y_dot, 0.0);
    EXPECT_EQ(e.mode, Mode::fault);
    EXPECT_TRUE(is_positive_definite(e.covariance));
  };
  expect_frozen(drive.last);
  // Driving forward again does not clear it, nor does a camera.
  drive.ticks(1000, {.speed = 1.0, .steering = 0.0, .yaw_rate = 0.0});
  const CameraPose camera{drive.now_ns, drive.now_ns, 1.0, 1.0, 1.0, 9.0, 9.0, 9.0};
  EXPECT_EQ(add(drive.filter, camera), Verdict::source_off);
  expect_frozen(drive.tick({.speed = 1.0}));
}

TEST(PaperFilter, SlowRollBackwardsWithinTheDomainIsNoFault) {
  Drive drive = start(Model::paper);
  drive.ticks(4000, {.speed = -0.03, .steering = 0.3, .yaw_rate = -0.03});
  EXPECT_FALSE(drive.last.model_fault);
  EXPECT_LT(drive.last.map.x, -0.5);
}

TEST(PaperFilter, NonFiniteStateIsNeverEmitted) {
  // Inputs within the physical limits, but Q and R that overflow the covariance.
  FilterSettings settings;
  settings.paper.Q = {1e308, 1e308, 1e308};
  settings.paper.R = {1e308, 1e308};
  Drive drive = start(Model::paper, settings);
  for (int i = 0; i < 100; ++i) {
    const Estimate e = drive.tick({.speed = 1.0, .steering = 0.3, .yaw_rate = 1.0});
    ASSERT_TRUE(is_finite(e.map));
    ASSERT_TRUE(is_finite(e.covariance));
    ASSERT_TRUE(is_finite(e.velocity_covariance));
    ASSERT_TRUE(std::isfinite(e.v_x) && std::isfinite(e.v_y) && std::isfinite(e.yaw_rate));
  }
  EXPECT_GT(drive.last.recoveries, 0U);
}

}  // namespace
}  // namespace odomd::estimator::testing::paper_filter_test
