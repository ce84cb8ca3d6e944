// Compares the paper's filter with its author's own, and tests when it stops.
#include "estimator/baselines/motion.hpp"
#include "estimator/filter.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/estimator/golden.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::paper_filter_test {
namespace {

using testing::Drive;
using testing::GoldenRow;
using testing::read_golden;
using testing::start;

constexpr double tolerance = 1e-9;

/// Steps the bare filter by a row: predict, correct, and the pose by forward Euler.
void advance(const GoldenRow& row, Motion& motion, Pose2& pose) {
  const FilterSettings settings;
  step_paper_ekf(settings, {row.steering, row.accel_x}, {row.yaw_rate, row.speed}, motion);
  const auto& [v_x, v_y, yaw_rate] = motion.velocity;
  const double dt = settings.period_s;
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  pose.x += dt * (v_x * c - v_y * s);
  pose.y += dt * (v_x * s + v_y * c);
  pose.yaw += dt * yaw_rate;
}

TEST(PaperEkf, AgreesWithTheAuthorsFilter) {
  Motion motion;
  Pose2 pose;
  double worst = 0.0;
  for (const GoldenRow& row : read_golden()) {
    advance(row, motion, pose);
    const BodyVelocity& v = motion.velocity;
    const std::array<double, 6> actual{v.v_x, v.v_y, v.yaw_rate, pose.x, pose.y, pose.yaw};
    for (std::size_t i = 0; i < actual.size(); ++i) {
      worst = std::max(worst, std::abs(actual[i] - row.expected[i]));
    }
  }
  EXPECT_LT(worst, tolerance);
}

TEST(PaperFilter, AgreesWithTheAuthorsFilterThroughTheSeam) {
  Drive drive = start(Model::paper);
  std::size_t step = 0;
  for (const GoldenRow& row : read_golden()) {
    const Estimate e = drive.tick({.speed = row.speed,
                                   .steering = row.steering,
                                   .yaw_rate = row.yaw_rate,
                                   .accel_x = row.accel_x});
    ASSERT_TRUE(e.initialised);
    const std::array<double, 6> in_map{e.v_x, e.v_y, e.yaw_rate, e.map.x, e.map.y, e.map.yaw};
    for (std::size_t i = 0; i < in_map.size(); ++i) {
      ASSERT_NEAR(in_map[i], row.expected[i], tolerance) << "column " << i << ", step " << step;
    }
    ASSERT_EQ(e.map.x, e.odom.x);
    ASSERT_EQ(e.map.yaw, e.odom.yaw);
    ++step;
  }
  EXPECT_EQ(step, 4000U);
}

TEST(PaperFilter, InitialPoseIsThatOfTheIntegration) {
  const Pose2 initial{3.0, -4.0, 1.2};
  Drive drive = start(Model::paper, {}, initial);
  Motion motion;
  Pose2 pose = initial;
  for (const GoldenRow& row : read_golden()) {
    advance(row, motion, pose);
    drive.tick({.speed = row.speed,
                .steering = row.steering,
                .yaw_rate = row.yaw_rate,
                .accel_x = row.accel_x});
  }
  EXPECT_NEAR(drive.last.map.x, pose.x, tolerance);
  EXPECT_NEAR(drive.last.map.y, pose.y, tolerance);
  EXPECT_NEAR(drive.last.map.yaw, pose.yaw, tolerance);
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

TEST(PaperFilter, HoldsTheNewestValueOfEachSignal) {
  Drive often = start(Model::paper);
  Drive seldom = start(Model::paper);
  for (int i = 0; i < 1000; ++i) {
    const int sample = i / 10;
    const double speed = 1.0 + 0.01 * sample;
    const testing::Samples samples{.speed = speed, .steering = 0.2, .yaw_rate = 0.5};
    often.tick(samples);
    seldom.tick(i % 10 == 0 ? samples : testing::Samples{});
    ASSERT_EQ(often.last.map.y, seldom.last.map.y);
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

TEST(PaperFilter, SteadyTurnIsThatOfTheErrata) {
  Drive drive = start(Model::paper);
  // Measure the yaw rate of the model's own steady state, so that the correction agrees with it.
  BodyVelocity steady{2.0, 0.0, 0.0};
  for (int i = 0; i < 2000; ++i) {
    steady = paper_step(Vehicle{}, steady, 0.1, 0.0, 0.005).velocity;
  }
  const Estimate e = drive.ticks(
      2000, {.speed = 2.0, .steering = 0.1, .yaw_rate = steady.yaw_rate, .accel_x = 0.0});
  EXPECT_NEAR(e.v_y, -0.030, 0.0005);
  EXPECT_NEAR(e.yaw_rate, steady.yaw_rate, 1e-9);
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
  // Within the physical limits, but with a car whose numbers overflow the covariance.
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
}  // namespace odomd::estimator::paper_filter_test
