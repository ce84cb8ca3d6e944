// Properties of every model behind the common interface.
#include "estimator/filter.hpp"

#include <limits>
#include <random>
#include <stdexcept>

#include "every_model.hpp"
#include "tests/gtest.hpp"
#include "tests/scratch.hpp"

namespace odomd::estimator::filter_test {
namespace {

using testing::millisecond;

INSTANTIATE_TEST_SUITE_P(, EveryModel, every_model, name_of_model);

TEST_P(EveryModel, IsInitialisedByAPoseAndAWheelSpeed) {
  // A camera does not initialise unless the settings allow it.
  Drive no_pose = start(GetParam(), {}, std::nullopt);
  no_pose.ticks(50, {.speed = 1.0, .steering = 0.1});
  const auto verdict = no_pose.see({1.0, 2.0, 0.5}, 0.01, 0.01);
  if (GetParam() != Model::full) {
    EXPECT_EQ(verdict, Verdict::source_off);
  }
  EXPECT_FALSE(no_pose.ticks(50, {.speed = 1.0, .steering = 0.1}).initialised);
  EXPECT_EQ(no_pose.last.mode, Mode::initialising);

  Drive no_wheel = start(GetParam(), {}, Pose2{1.0, 2.0, 3.0});
  EXPECT_FALSE(no_wheel.ticks(100, {.steering = 0.1, .yaw_rate = 0.5}).initialised);
  EXPECT_EQ(no_wheel.last.map.x, 1.0);
  no_wheel.tick({.speed = 1.0});
  // The full filter needs a second speed to confirm the first.
  EXPECT_TRUE(no_wheel.tick({.speed = 1.0}).initialised);
  EXPECT_EQ(no_wheel.last.reset_count, 1U);
}

TEST_P(EveryModel, PoseSetLateStartsThereAndIsKeptWhenOlderSamplesArrive) {
  Drive drive = start(GetParam(), {}, std::nullopt);
  drive.ticks(100, {.speed = 1.0});
  set_initial_pose(drive.filter, {4.0, 5.0, 0.0});
  for (int i = 0; i < 10; ++i) {
    const Estimate e = drive.tick({.speed = 1.0});
    ASSERT_TRUE(e.initialised);
    EXPECT_NEAR(e.map.x, 4.0 + 0.005 * i, 0.01);
    EXPECT_NEAR(e.map.y, 5.0, 0.01);
    EXPECT_NEAR(e.map.x, e.odom.x, 1e-4);
    EXPECT_EQ(e.reset_count, 1U);
    drive.send(Source::yaw_rate, 0.0, 0.01, 15 * millisecond);
  }
}

TEST_P(EveryModel, NonFiniteInitialPoseIsIgnored) {
  Drive drive = start(GetParam(), {}, Pose2{std::nan(""), 0.0, 0.0});
  EXPECT_FALSE(drive.ticks(10, {.speed = 1.0}).initialised);
}

TEST_P(EveryModel, CameraInitialisesAndTracks) {
  FilterSettings settings;
  settings.initialise_from_camera = true;
  Drive drive = start(GetParam(), settings, std::nullopt);
  drive.ticks(20, {.speed = 0.0});
  EXPECT_FALSE(drive.last.initialised);
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(taken(drive.see({2.0, 3.0, 1.0}, 0.01, 0.01, 40 * millisecond)));
    drive.ticks(7, {.speed = 0.0});
  }
  EXPECT_TRUE(drive.last.initialised);
  EXPECT_EQ(drive.last.mode, Mode::tracking);
  EXPECT_NEAR(drive.last.map.x, 2.0, 1e-3);
  // The full filter does not re-anchor: a pose corrects it.
  EXPECT_EQ(drive.last.reset_count, GetParam() == Model::full ? 1U : 5U);
  EXPECT_EQ(drive.ticks(150, {.speed = 0.0}).mode, Mode::standstill);
  EXPECT_EQ(drive.ticks(5, {.speed = 0.5}).mode, Mode::dead_reckoning);
}

TEST_P(EveryModel, GivesTheSameBitsForTheSameInputsAndAsACopy) {
  Drive drive = slalom_for(GetParam(), 500);
  Drive copy = drive;
  for (int i = 500; i < 2000; ++i) expect_same_bits(drive.tick(slalom(i)), copy.tick(slalom(i)));
  expect_same_bits(slalom_for(GetParam(), 2000).last, drive.last);
}

TEST_P(EveryModel, AShiftOfAMicrosecondHasNoEffect) {
  Drive on_time = start(GetParam());
  Drive shifted = start(GetParam());
  for (int i = 0; i < 2000; ++i) {
    on_time.tick(slalom(i));
    // Ticks alternate between a microsecond early and late, with their samples and camera poses.
    shifted.now_ns = on_time.now_ns - period_ns + (i % 2 == 0 ? 1000 : -1000);
    shifted.tick(slalom(i));
    if (i > 100 && i % 7 == 0) {
      for (Drive* drive : {&on_time, &shifted})
        EXPECT_TRUE(taken(drive->see(on_time.last.map, 0.5, 0.5, 105 * millisecond)));
    }
  }
  EXPECT_THAT(on_time.last.map, testing::PoseNear(shifted.last.map, 1e-4));
}

TEST_P(EveryModel, SkippedTicksAreSteppedThroughWithHeldInputs) {
  const Samples steady{.speed = 1.0, .steering = 0.1, .yaw_rate = 0.38, .accel_x = 0.0};
  Drive whole = start(GetParam());
  whole.ticks(100, steady);
  Drive gappy = whole;
  const Estimate e = whole.ticks(50, steady);
  gappy.now_ns += 49 * period_ns;
  const Estimate made_up = gappy.tick(steady);
  if (GetParam() == Model::full) {  // it needs samples, and the gap had none
    EXPECT_NEAR(made_up.map.x, e.map.x, 1e-3);
    EXPECT_NEAR(made_up.map.y, e.map.y, 1e-3);
    EXPECT_NEAR(made_up.odom.x, e.odom.x, 1e-3);
    EXPECT_GE(made_up.covariance[0], e.covariance[0]);
    return;
  }
  expect_same_bits(made_up, e);
}

TEST_P(EveryModel, StepsThroughAtMostASecondAndGrowsTheCovarianceBeyond) {
  const Samples straight{.speed = 1.0, .steering = 0.0, .yaw_rate = 0.0, .accel_x = 0.0};
  Drive drive = start(GetParam());
  const Estimate before = drive.ticks(400, straight);
  drive.now_ns += 10'000'000'000;
  const Estimate after = drive.tick(straight);
  EXPECT_EQ(after.time_ns, drive.now_ns);
  EXPECT_NEAR(after.map.x - before.map.x, 1.0, 0.01);
  EXPECT_NEAR(after.odom.x - before.odom.x, 1.0, 0.01);
  EXPECT_GT(std::sqrt(after.covariance[0]), 9.0);
  EXPECT_TRUE(is_positive_definite(after.covariance));
}

TEST_P(EveryModel, TickThatDoesNotAdvanceReturnsTheLastEstimate) {
  Drive drive = slalom_for(GetParam(), 200);
  const Estimate last = drive.last;
  for (const std::int64_t tick :
       {drive.now_ns, drive.now_ns - period_ns, drive.now_ns + period_ns / 2 - 1,
        std::numeric_limits<std::int64_t>::min()})
    expect_same_bits(step(drive.filter, tick), last);
}

TEST_P(EveryModel, TickAtTheEndOfTimeIsSurvived) {
  Drive drive = slalom_for(GetParam(), 200);
  const Estimate e = step(drive.filter, std::numeric_limits<std::int64_t>::max());
  EXPECT_TRUE(std::isfinite(e.map.x));
  EXPECT_TRUE(is_positive_definite(e.covariance));
}

TEST_P(EveryModel, SamplesFromTheFutureAreRefusedByTheirArrivalOrTheTick) {
  Drive drive = slalom_for(GetParam(), 10);
  const std::int64_t next = drive.now_ns + period_ns;
  const auto verdict = [&](std::int64_t time, std::int64_t arrival) {
    return add(drive.filter, Measurement{Source::motor, time, 1.0, 0.1, arrival});
  };
  EXPECT_EQ(verdict(next + period_ns + 1, 0), Verdict::future);
  EXPECT_TRUE(taken(verdict(next + period_ns, 0)));
  // Ticks were skipped: a sample that arrived in the gap is not from the future.
  EXPECT_TRUE(taken(verdict(next + 20 * period_ns, next + 20 * period_ns)));
  EXPECT_EQ(verdict(next + 22 * period_ns, next + 20 * period_ns), Verdict::future);
}

TEST_P(EveryModel, TheNoiseOfASourceIsEstimatedByTheFullFilter) {
  FilterSettings settings;
  settings.sigma[index_of(Source::yaw_rate)] = 0.04;
  Drive drive = start(GetParam(), settings);
  std::mt19937 random(5);
  std::normal_distribution<double> scatter(0.0, 0.02);
  for (int i = 0; i < 1000; ++i)
    drive.tick({.speed = 1.0, .steering = 0.0, .yaw_rate = scatter(random)});
  const SourceNoise gyro = noise(drive.filter, Source::yaw_rate);
  const SourceNoise wheel = noise(drive.filter, Source::wheel_rear);
  EXPECT_EQ(gyro.estimated(), GetParam() == Model::full);
  EXPECT_EQ(wheel.estimated(), GetParam() == Model::full);
  if (GetParam() != Model::full) return;
  EXPECT_EQ(gyro.stated, 0.04);
  EXPECT_NEAR(gyro.moving, 0.02, 0.002);
  EXPECT_EQ(wheel.stated, default_sigma[index_of(Source::wheel_rear)]);
}

TEST_P(EveryModel, StandingCarDoesNotAccelerate) {
  Drive drive = start(GetParam());
  const Estimate e =
      drive.ticks(400, {.speed = 0.0, .steering = 0.4, .yaw_rate = 0.012, .accel_x = 0.3});
  EXPECT_EQ(e.mode, Mode::standstill);
  EXPECT_THAT((std::array{e.v_x_dot, e.v_y_dot, e.yaw_accel}), ::testing::Each(0.0));
}

TEST(MakeFilter, RefusesImpossibleSettingsByName) {
  using Settings = FilterSettings;
  using Change = void (*)(Settings&);
  for (const auto& [name, change] : {
           std::pair<const char*, Change>{"vehicle.mass",
                                          [](Settings& s) { s.vehicle.mass = 0.0; }},
           {"period", [](Settings& s) { s.period_s = std::nan(""); }},
           {"period", [](Settings& s) { s.period_s = 2.0; }},
           {"motor", [](Settings& s) { s.sigma[index_of(Source::motor)] = std::nan(""); }},
           {"R[1]", [](Settings& s) { s.paper.R[1] = -1.0; }},
       }) {
    Settings settings;
    change(settings);
    EXPECT_THAT(message_of([&] { (void)make_filter(Model::paper, settings); }), HasSubstr(name));
  }
  EXPECT_THROW((void)make_filter(static_cast<Model>(9), {}), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::estimator::filter_test
