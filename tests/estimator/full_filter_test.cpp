// The full filter as a whole: its start from a camera pose, at rest, or from a predecessor; a flood
// of samples, a long gap, a wrong camera.
#include "estimator/full_filter.hpp"

#include <cstring>
#include <optional>
#include <random>

#include "circle_drive.hpp"
#include "estimator/common/pose.hpp"
#include "tests/estimator/drive.hpp"

namespace odomd::estimator::testing::full_filter_test {
namespace {

TEST(FullFilter, ACommandTurnsTheWheelsAfterItsDelay) {
  // A servo with a delay of 40 ms, commanded 40 ms earlier, gives the same drive as a servo without
  // delay.
  const auto run_with = [](double delay_s) {
    FilterSettings settings;
    settings.vehicle.steering.delay_s = delay_s;
    FullFilter filter(settings);
    filter.set_initial_pose({});
    std::vector<Arrival> arrivals = drive_on_a_circle(1'000 * millisecond);
    for (Arrival& arrival : arrivals) {
      if (arrival.signal && arrival.signal->source == Source::steering) {
        arrival.signal->value += 1e-10 * static_cast<double>(arrival.signal->time_ns - start_ns);
        arrival.signal->time_ns -= std::llround(delay_s * 1e9);
      }
    }
    return run(filter, arrivals, 200).back();
  };
  expect_same_state(run_with(0.04), run_with(0.0));
}

TEST(FullFilter, EverySampleOfAFloodHasAVerdict) {
  FullFilter filter = started();
  (void)run(filter, {}, 10);
  const std::int64_t tick = start_ns + 11 * period_ns;
  std::array<std::uint64_t, source_count> offered{};
  std::array<std::uint64_t, source_count> reported{};
  std::uint64_t too_old = 0;
  // Six times the window's capacity, between two ticks and in no order.
  std::mt19937 random(13);
  for (std::size_t i = 0; i < 6 * full::SampleWindow::capacity; ++i) {
    const std::int64_t taken = tick - static_cast<std::int64_t>(random() % 40'000'000);
    const Source source = i % 50 == 0  ? Source::camera
                          : i % 3 == 0 ? Source::wheel_rear
                                       : Source::yaw_rate;
    const std::optional<Verdict> verdict =
        source == Source::camera ? filter.add(CameraPose{taken, tick, 0, 0, 0, 0.01, 0.01, 0.01})
                                 : filter.add(Measurement{source, taken, 0.0, 0.01, tick});
    ++offered[index_of(source)];
    reported[index_of(source)] += verdict ? 1U : 0U;
    too_old += verdict == Verdict::too_old ? 1U : 0U;
  }
  (void)filter.step(tick);
  for (const Judgement& judgement : filter.judgements()) {
    reported[index_of(judgement.source)] += judgement.count;
    if (judgement.verdict == Verdict::too_old) {
      too_old += judgement.count;
      EXPECT_EQ(judgement.degrees, 0);
    }
  }
  EXPECT_EQ(reported, offered);
  EXPECT_EQ(too_old, 5 * full::SampleWindow::capacity);
}

TEST(FullFilter, ASampleThatIsOlderThanTheWindowIsRefused) {
  FullFilter filter = started();
  (void)run(filter, drive_on_a_circle(1'000 * millisecond), 200);
  const std::int64_t now = start_ns + 200 * period_ns;
  EXPECT_EQ(filter.add(Measurement{Source::yaw_rate, now - 251 * millisecond, 0.0, 0.01}),
            Verdict::too_old);
  EXPECT_EQ(filter.add(Measurement{Source::yaw_rate, now - 249 * millisecond, 1.0, 0.01}),
            std::nullopt);
}

TEST(FullFilter, AfterASleepTheVelocityIsAsUncertainAsThePose) {
  constexpr std::int64_t second = 1'000 * millisecond;
  FullFilter filter = started();
  const Estimate before = run(filter, drive_on_a_circle(1 * second), 200).back();
  const Estimate after = filter.step(start_ns + 60 * second);
  EXPECT_GT(after.velocity_covariance[0], 1e3);
  // The distance driven in that minute is unknown: it is not extrapolated at the last speed.
  EXPECT_GT(after.covariance[0], 1e5);
  EXPECT_LT(std::hypot(after.odom.x - before.odom.x, after.odom.y - before.odom.y), 3.0);
  // The car has been put down elsewhere, and is at rest.
  Estimate last;
  for (std::int64_t tick = 1; tick <= 20; ++tick) {
    const std::int64_t now = start_ns + 60 * second + tick * period_ns;
    (void)filter.add(Measurement{Source::wheel_rear, now - millisecond, 0.0, 0.01});
    last = filter.step(now);
  }
  EXPECT_NEAR(last.v_x, 0.0, 0.01);
}

constexpr Pose2 jump{1.0, -2.0, 0.0};

/// From `first_ns` to `last_ns` the camera sees the car elsewhere.
void displace_camera(std::vector<Arrival>& arrivals, std::int64_t first_ns, std::int64_t last_ns) {
  for (Arrival& arrival : arrivals) {
    if (!arrival.camera || arrival.camera->capture_ns < first_ns ||
        arrival.camera->capture_ns > last_ns)
      continue;
    arrival.camera->x += jump.x;
    arrival.camera->y += jump.y;
  }
}

TEST(FullFilter, ACameraThatIsRightMovesTheMapOnceAndTheOdometryFrameNever) {
  std::vector<Arrival> arrivals = drive_on_a_circle(5'000 * millisecond);
  displace_camera(arrivals, start_ns + 3'001 * millisecond, start_ns + 5'000 * millisecond);
  const std::vector<Estimate> estimates = run(arrivals, 1000);
  for (std::size_t i = 1; i < estimates.size(); ++i) {
    const Estimate& before = estimates[i - 1];
    const Estimate& e = estimates[i];
    const double step = std::hypot(e.odom.x - before.odom.x, e.odom.y - before.odom.y);
    EXPECT_NEAR(step, 2.0 * 0.005, 5e-4) << i;
    EXPECT_TRUE(e.time_ns <= start_ns + 3'000 * millisecond ? e.reset_count == 1
                                                            : e.reset_count <= 2);
  }
  const Estimate& last = estimates.back();
  EXPECT_EQ(last.reset_count, 2U);
  EXPECT_THAT(last.last_jump, PoseNear(jump, 0.05));
  EXPECT_EQ(last.mode, Mode::tracking);
  EXPECT_THAT(last.map - on_circle(last.time_ns), PoseNear(jump, 0.02));
}

TEST(FullFilter, AJumpThatALatePoseTakesBackIsOneMoreJump) {
  // Two poses agree on another position; a pose between them contradicts it, but arrives later.
  std::vector<Arrival> arrivals = drive_on_a_circle(2'000 * millisecond);
  const std::int64_t first = start_ns + 1'015 * millisecond;
  const std::int64_t last = first + 35 * millisecond;
  displace_camera(arrivals, first, last);
  const std::int64_t between = first + 20 * millisecond;
  const std::int64_t late = last + 60 * millisecond;
  const Pose2 truth = on_circle(between);
  arrivals.push_back(
      {late, {}, CameraPose{between, late, truth.x, truth.y, truth.yaw, 0.008, 0.008, 0.009}});
  std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_ns);

  const std::vector<Estimate> estimates = run(arrivals, 300);
  const auto at = [&](std::int64_t time_ns) -> const Estimate& {
    return estimates.at(static_cast<std::size_t>(tick_of(time_ns) - 1));
  };
  const Estimate& reset = at(late - period_ns);
  ASSERT_EQ(reset.reset_count, 2U);
  EXPECT_THAT(reset.last_jump, PoseNear(jump, 0.05));
  const Estimate& back = at(late);
  EXPECT_EQ(back.reset_count, 3U);
  EXPECT_THAT(back.last_jump, PoseNear(Pose2{} - jump, 0.05));
  EXPECT_THAT(back.map - reset.map, PoseNear(Pose2{} - jump, 0.05));
  EXPECT_EQ(estimates.back().reset_count, 3U);
}

TEST(FullFilter, CoversACarThatReversesUntilTheSignOfItsWheelsIsKnown) {
  // 1 s at rest, to 0.5 m/s within 0.5 s, 2 s at that speed, a halt. An accelerometer shows the
  // sign.
  for (const bool accelerometer : {false, true}) {
    Drive drive = start(Model::full);
    const auto go = [&](int ticks, double from, double accel) {
      for (int i = 0; i < ticks; ++i) {
        const double noise = i % 2 == 0 ? 1e-2 : -1e-2;
        const double speed = from + accel * 0.005 * i;
        drive.tick(accelerometer
                       ? Samples{.speed = speed, .yaw_rate = 0.01 * noise, .accel_x = accel + noise}
                       : Samples{.speed = speed, .yaw_rate = 0.01 * noise});
      }
      return std::sqrt(drive.last.covariance[0]);
    };
    go(200, 0.0, 0.0);
    go(100, 0.0, 1.0);
    const double moving = go(400, 0.5, 0.0);
    const double v_x = std::sqrt(drive.last.velocity_covariance[0]);
    go(100, 0.5, -1.0);
    const double halted = go(200, 0.0, 0.0);
    // Backwards, the position would be wrong by twice the distance of 1.1 m, at 3 sigma.
    EXPECT_EQ(moving > 2.0 / 3.0, !accelerometer) << moving;
    EXPECT_EQ(v_x > 0.3, !accelerometer) << v_x;
    EXPECT_EQ(halted > 2.0 / 3.0, !accelerometer) << halted;
  }
}

// The start
// ---------------------------------------------------------------------------------------------

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
  EXPECT_THAT(e.map, PoseNear(moved({1.0, 2.0, 0.5}, {2.0, 0.0, 0.0}, 0.05), 0.01));
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
  EXPECT_EQ(numbers_of(first.odom), numbers_of(first.map));
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

TEST(Begin, ResumesDuringADrive) {
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

TEST(Begin, IgnoresInvalidCalibrationsOfItsPredecessor) {
  Estimate predecessor = run(drive_on_a_circle(500 * millisecond), 100).back();
  predecessor.calibration.value.fill(std::nan(""));
  predecessor.calibration.sigma = {0.001, 0.0, -1.0, 1e9, std::nan(""), 0.001, 0.0};
  FullFilter filter({});
  ASSERT_TRUE(filter.resume(predecessor, 0.3));
  const Estimate e = filter.step(start_ns);
  EXPECT_EQ(e.calibration.value, FullFilter({}).step(start_ns).calibration.value);
  EXPECT_EQ(e.calibration.valid, 0U);
}

TEST(Begin, ItsBytesAreItsWholeState) {
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
}  // namespace odomd::estimator::testing::full_filter_test
