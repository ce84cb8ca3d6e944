// The full filter as a whole: a flood of samples, a long gap, a wrong camera.
#include "estimator/full_filter.hpp"

#include <optional>
#include <random>

#include "circle_drive.hpp"
#include "estimator/common/pose.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/gtest.hpp"

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
  testing::expect_same_state(run_with(0.04), run_with(0.0));
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
    if (i % 50 == 0) {
      ++offered[index_of(Source::camera)];
      if (const auto verdict = filter.add(CameraPose{taken, tick, 0, 0, 0, 0.01, 0.01, 0.01})) {
        ++reported[index_of(Source::camera)];
        too_old += *verdict == Verdict::too_old ? 1U : 0U;
      }
      continue;
    }
    const Source source = i % 3 == 0 ? Source::wheel_rear : Source::yaw_rate;
    ++offered[index_of(source)];
    if (const auto verdict = filter.add(Measurement{source, taken, 0.0, 0.01, tick})) {
      ++reported[index_of(source)];
      too_old += *verdict == Verdict::too_old ? 1U : 0U;
    }
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

TEST(FullFilter, ACameraThatIsRightMovesTheMapOnceAndTheOdometryFrameNever) {
  std::vector<Arrival> arrivals = drive_on_a_circle(5'000 * millisecond);
  for (Arrival& arrival : arrivals) {
    if (arrival.camera && arrival.camera->capture_ns > start_ns + 3'000 * millisecond) {
      arrival.camera->x += 1.0;
      arrival.camera->y -= 2.0;
    }
  }
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
  EXPECT_NEAR(last.last_jump.x, 1.0, 0.05);
  EXPECT_NEAR(last.last_jump.y, -2.0, 0.05);
  EXPECT_EQ(last.mode, Mode::tracking);
  const Pose2 truth = testing::on_circle(last.time_ns);
  EXPECT_NEAR(last.map.x, truth.x + 1.0, 0.02);
  EXPECT_NEAR(last.map.y, truth.y - 2.0, 0.02);
}

TEST(FullFilter, AJumpThatALatePoseTakesBackIsOneMoreJump) {
  // Two poses agree on another position; a pose between them contradicts it, but arrives later.
  std::vector<Arrival> arrivals = drive_on_a_circle(2'000 * millisecond);
  const std::int64_t first = start_ns + 1'015 * millisecond;
  const std::int64_t last = first + 35 * millisecond;
  for (Arrival& arrival : arrivals) {
    if (arrival.camera && arrival.camera->capture_ns >= first &&
        arrival.camera->capture_ns <= last) {
      arrival.camera->x += 1.0;
      arrival.camera->y -= 2.0;
    }
  }
  const std::int64_t between = first + 20 * millisecond;
  const std::int64_t late = last + 60 * millisecond;
  const Pose2 truth = testing::on_circle(between);
  arrivals.push_back(
      {late, {}, CameraPose{between, late, truth.x, truth.y, truth.yaw, 0.008, 0.008, 0.009}});
  std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_ns);

  const std::vector<Estimate> estimates = run(arrivals, 300);
  const auto at = [&](std::int64_t time_ns) -> const Estimate& {
    return estimates.at(static_cast<std::size_t>(tick_of(time_ns) - 1));
  };
  const Estimate& reset = at(late - period_ns);
  ASSERT_EQ(reset.reset_count, 2U);
  EXPECT_NEAR(reset.last_jump.x, 1.0, 0.05);
  EXPECT_NEAR(reset.last_jump.y, -2.0, 0.05);
  const Estimate& back = at(late);
  EXPECT_EQ(back.reset_count, 3U);
  EXPECT_NEAR(back.last_jump.x, -1.0, 0.05);
  EXPECT_NEAR(back.last_jump.y, 2.0, 0.05);
  EXPECT_NEAR(back.map.x - reset.map.x, -1.0, 0.05);
  EXPECT_NEAR(back.map.y - reset.map.y, 2.0, 0.05);
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

}  // namespace
}  // namespace odomd::estimator::testing::full_filter_test
