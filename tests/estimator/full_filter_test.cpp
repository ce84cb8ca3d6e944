// The full filter as a whole: what late, shuffled, wrong and missing samples make of it.
#include "estimator/full_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <random>
#include <vector>

#include "estimator/pose.hpp"
#include "full/circle_drive.hpp"

namespace odomd::estimator::full_filter_test {
namespace {

using testing::Arrival;
using testing::circle;
using testing::drive_on_a_circle;
using testing::eventful_drive;
using testing::expect_same_frames;
using testing::expect_same_state;
using testing::hand_in;
using testing::millisecond;
using testing::period_ns;
using testing::run;
using testing::shuffled;
using testing::start_ns;
using testing::started;

/// The tick that takes an arrival in.
std::int64_t tick_of(std::int64_t arrival_ns) {
  return (arrival_ns - start_ns + period_ns - 1) / period_ns;
}

TEST(FullFilter, FollowsACircleWithALateCamera) {
  FullFilter filter = started();
  const auto estimates = run(filter, drive_on_a_circle(5'000 * millisecond), 1000);
  const Estimate& last = estimates.back();
  const Pose2 truth = moved({}, circle, static_cast<double>(last.time_ns - start_ns) * 1e-9);
  EXPECT_NEAR(last.map.x, truth.x, 0.02);
  EXPECT_NEAR(last.map.y, truth.y, 0.02);
  EXPECT_NEAR(last.map.yaw, truth.yaw, 0.01);
  EXPECT_NEAR(last.v_x, 2.0, 0.02);
  EXPECT_NEAR(last.yaw_rate, 1.0, 0.02);
  EXPECT_EQ(last.mode, Mode::tracking);
}

TEST(FullFilter, AnyOrderOfArrivalInsideTheWindowGivesTheSameBits) {
  const std::vector<Arrival> in_order = drive_on_a_circle(1'000 * millisecond);
  // In the end everything has arrived: 200 ticks, and what is missing comes 240 ms late at most.
  constexpr std::int64_t ticks = 200;
  FullFilter reference = started();
  const Estimate expected = run(reference, in_order, ticks).back();

  std::mt19937 random(11);
  for (int permutation = 0; permutation < 5; ++permutation) {
    FullFilter filter = started();
    const std::vector<Arrival> in_any_order =
        shuffled(in_order, start_ns + ticks * period_ns, random);
    expect_same_state(run(filter, in_any_order, ticks).back(), expected);
  }
}

TEST(FullFilter, AnyOrderOfArrivalGivesTheSameBitsThroughGatesSlipRestAndReset) {
  const std::vector<Arrival> in_order = eventful_drive();
  constexpr std::int64_t ticks = 800;
  FullFilter reference = started();
  // What is to happen does.
  std::array<int, source_count> gated{};
  bool stood = false;
  Estimate expected;
  std::size_t next = 0;
  for (std::int64_t k = 1; k <= ticks; ++k) {
    const std::int64_t now = start_ns + k * period_ns;
    for (; next < in_order.size() && in_order[next].arrival_ns <= now; ++next) {
      hand_in(reference, in_order[next]);
    }
    expected = reference.step(now);
    stood = stood || expected.mode == Mode::standstill;
    for (const Judgement& judgement : reference.judgements()) {
      gated[index_of(judgement.source)] += judgement.verdict == Verdict::gated ? 1 : 0;
    }
  }
  ASSERT_TRUE(stood);
  ASSERT_GT(gated[index_of(Source::yaw_rate)], 0);
  ASSERT_GT(gated[index_of(Source::wheel_rear_left)], 10);
  ASSERT_GT(gated[index_of(Source::camera)], 4);
  ASSERT_EQ(expected.reset_count, 2U);
  ASSERT_NEAR(expected.last_jump.y, -2.0, 0.05);

  std::mt19937 random(14);
  for (int permutation = 0; permutation < 5; ++permutation) {
    FullFilter filter = started();
    const std::vector<Arrival> in_any_order =
        shuffled(in_order, start_ns + ticks * period_ns, random);
    const Estimate e = run(filter, in_any_order, ticks).back();
    expect_same_state(e, expected);
    EXPECT_EQ(e.camera_ns, expected.camera_ns);
  }
}

TEST(FullFilter, EverySampleOfAFloodHasAVerdict) {
  FullFilter filter = started();
  (void)run(filter, {}, 10);
  const std::int64_t tick = start_ns + 11 * period_ns;
  std::array<std::uint64_t, source_count> offered{};
  std::array<std::uint64_t, source_count> told{};
  std::uint64_t too_old = 0;
  // Six times of what the window holds, between two ticks and in no order.
  std::mt19937 random(13);
  for (std::size_t i = 0; i < 6 * full::SampleWindow::capacity; ++i) {
    const std::int64_t taken = tick - static_cast<std::int64_t>(random() % 40'000'000);
    if (i % 50 == 0) {
      ++offered[index_of(Source::camera)];
      if (const auto verdict = filter.add(CameraPose{taken, tick, 0, 0, 0, 0.01, 0.01, 0.01})) {
        ++told[index_of(Source::camera)];
        too_old += *verdict == Verdict::too_old ? 1U : 0U;
      }
      continue;
    }
    const Source source = i % 3 == 0 ? Source::wheel_rear : Source::yaw_rate;
    ++offered[index_of(source)];
    if (const auto verdict = filter.add(Measurement{source, taken, 0.0, 0.01, tick})) {
      ++told[index_of(source)];
      too_old += *verdict == Verdict::too_old ? 1U : 0U;
    }
  }
  (void)filter.step(tick);
  for (const Judgement& judgement : filter.judgements()) {
    told[index_of(judgement.source)] += judgement.count;
    if (judgement.verdict == Verdict::too_old) {
      too_old += judgement.count;
      EXPECT_EQ(judgement.degrees, 0);
    }
  }
  EXPECT_EQ(told, offered);
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

TEST(FullFilter, OrderOfArrivalWithinATickLeavesTheBitsOfBothFramesAlone) {
  const std::vector<Arrival> in_order = drive_on_a_circle(1'000 * millisecond);
  FullFilter reference = started();
  const std::vector<Estimate> expected = run(reference, in_order, 200);
  std::mt19937 random(12);
  for (int permutation = 0; permutation < 5; ++permutation) {
    std::vector<Arrival> arrivals = in_order;
    std::ranges::shuffle(arrivals, random);
    std::ranges::stable_sort(arrivals, {}, [](const Arrival& a) { return tick_of(a.arrival_ns); });
    FullFilter filter = started();
    const std::vector<Estimate> estimates = run(filter, arrivals, 200);
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      expect_same_frames(estimates[i], expected[i]);
    }
  }
}

TEST(FullFilter, OfTwoClaimsOfOneSampleTheSameOneCountsInAnyOrder) {
  const std::vector<Arrival> arrivals = drive_on_a_circle(500 * millisecond);
  const std::int64_t taken = start_ns + 390 * millisecond + 1;
  const Measurement one{Source::yaw_rate, taken, 1.02, 0.005};
  const Measurement other{Source::yaw_rate, taken, 0.97, 0.005};
  const CameraPose here{taken, 0, 0.72, 0.15, 0.39, 0.008, 0.008, 0.009};
  const CameraPose there{taken, 0, 0.71, 0.16, 0.39, 0.008, 0.008, 0.009};

  // Both at once, or the second when the first has long been fused.
  for (const int ticks_between : {0, 5}) {
    const auto end_with = [&](const auto& first, const auto& second) {
      FullFilter filter = started();
      (void)run(filter, arrivals, 79);
      EXPECT_EQ(filter.add(first), std::nullopt);
      for (int i = 0; i < ticks_between; ++i) {
        (void)filter.step(start_ns + (80 + i) * period_ns);
      }
      EXPECT_EQ(filter.add(second), Verdict::duplicate);
      return filter.step(start_ns + 90 * period_ns);
    };
    expect_same_state(end_with(one, other), end_with(other, one));
    expect_same_state(end_with(here, there), end_with(there, here));
  }
}

TEST(FullFilter, ALateSampleCountsAsIfItHadComeInTime) {
  const std::vector<Arrival> arrivals = drive_on_a_circle(1'000 * millisecond);
  const Measurement sample{Source::wheel_rear, start_ns + 701 * millisecond, 2.3, 0.01};
  FullFilter in_time = started();
  EXPECT_EQ(in_time.add(sample), std::nullopt);
  const Estimate expected = run(in_time, arrivals, 190).back();

  FullFilter late = started();
  (void)run(late, arrivals, 189);
  EXPECT_EQ(late.add(sample), std::nullopt);
  // The last tick once more, with what arrives in it.
  for (const Arrival& arrival : arrivals) {
    if (tick_of(arrival.arrival_ns) == 190) {
      hand_in(late, arrival);
    }
  }
  expect_same_state(late.step(start_ns + 190 * period_ns), expected);
}

TEST(FullFilter, SkippedTicksLeaveTheSameBitsOnceTheirSamplesAreThere) {
  const std::vector<Arrival> arrivals = drive_on_a_circle(1'000 * millisecond);
  FullFilter every = started();
  const Estimate expected = run(every, arrivals, 180).back();
  FullFilter some = started();
  std::size_t next = 0;
  Estimate last;
  for (const std::int64_t tick : {1, 2, 3, 10, 11, 25, 60, 61, 100, 140, 180}) {
    const std::int64_t now = start_ns + tick * period_ns;
    for (; next < arrivals.size() && arrivals[next].arrival_ns <= now; ++next) {
      hand_in(some, arrivals[next]);
    }
    last = some.step(now);
  }
  expect_same_state(last, expected);
}

TEST(FullFilter, TheOdometryFrameOfSkippedTicksIsThatOfEveryTick) {
  const std::vector<Arrival> arrivals = drive_on_a_circle(500 * millisecond);
  FullFilter every = started();
  FullFilter some = started();
  (void)run(every, arrivals, 120);
  (void)run(some, arrivals, 120);
  // Nothing is heard any more, and the tyres take the car out of its circle.
  Estimate expected;
  for (std::int64_t tick = 121; tick <= 240; ++tick) {
    expected = every.step(start_ns + tick * period_ns);
  }
  expect_same_frames(some.step(start_ns + 240 * period_ns), expected);
}

TEST(FullFilter, AfterASleepTheVelocityIsAsUncertainAsThePose) {
  constexpr std::int64_t second = 1'000 * millisecond;
  FullFilter filter = started();
  const Estimate before = run(filter, drive_on_a_circle(1 * second), 200).back();
  const Estimate after = filter.step(start_ns + 60 * second);
  EXPECT_GT(after.velocity_covariance[0], 1e3);
  // The way of a minute is unknown; it was not driven at the last speed either.
  EXPECT_GT(after.covariance[0], 1e5);
  EXPECT_LT(std::hypot(after.odom.x - before.odom.x, after.odom.y - before.odom.y), 3.0);
  // The car has been put down elsewhere, and stands.
  Estimate last;
  for (std::int64_t tick = 1; tick <= 20; ++tick) {
    const std::int64_t now = start_ns + 60 * second + tick * period_ns;
    (void)filter.add(Measurement{Source::wheel_rear, now - millisecond, 0.0, 0.01});
    last = filter.step(now);
  }
  EXPECT_NEAR(last.v_x, 0.0, 0.01);
}

TEST(FullFilter, BitsDoNotDependOnTheEpoch) {
  // Decades later, on the grid of the ticks.
  constexpr std::int64_t later_ns = 1'760'000'000'000'000'000;
  const std::vector<Arrival> arrivals = drive_on_a_circle(500 * millisecond);
  FullFilter reference = started();
  const std::vector<Estimate> expected = run(reference, arrivals, 100);
  FullFilter filter = started();
  std::size_t next = 0;
  for (std::int64_t k = 1; k <= 100; ++k) {
    const std::int64_t now = start_ns + k * period_ns;
    for (; next < arrivals.size() && arrivals[next].arrival_ns <= now; ++next) {
      Arrival moved = arrivals[next];
      if (moved.signal) {
        moved.signal->time_ns += later_ns;
        moved.signal->arrival_ns += later_ns;
      } else {
        moved.camera->capture_ns += later_ns;
        moved.camera->arrival_ns += later_ns;
      }
      hand_in(filter, moved);
    }
    expect_same_frames(filter.step(now + later_ns), expected[static_cast<std::size_t>(k - 1)]);
  }
}

TEST(FullFilter, AMicrosecondOfShiftMovesThePoseByHardlyMoreThanTheCarMoves) {
  const std::vector<Arrival> arrivals = drive_on_a_circle(3'000 * millisecond);
  FullFilter reference = started();
  const std::vector<Estimate> expected = run(reference, arrivals, 600);
  for (const std::int64_t shift_ns : {-1000, 1000}) {
    std::vector<Arrival> shifted = arrivals;
    for (Arrival& arrival : shifted) {
      if (arrival.signal) {
        arrival.signal->time_ns += shift_ns;
      } else {
        arrival.camera->capture_ns += shift_ns;
      }
    }
    FullFilter filter = started();
    const std::vector<Estimate> estimates = run(filter, shifted, 600);
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      EXPECT_NEAR(estimates[i].map.x, expected[i].map.x, 1e-5) << i;
      EXPECT_NEAR(estimates[i].map.y, expected[i].map.y, 1e-5) << i;
      EXPECT_NEAR(estimates[i].map.yaw, expected[i].map.yaw, 1e-5) << i;
    }
  }
}

TEST(FullFilter, ACameraPoseFromBeforeTheFirstTickInitialises) {
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
  // Where it is now, not where it was seen.
  EXPECT_NEAR(e.map.x, 1.0 + 0.1 * std::cos(0.5), 0.01);
  EXPECT_NEAR(e.map.y, 2.0 + 0.1 * std::sin(0.5), 0.01);
  EXPECT_NEAR(e.map.yaw, 0.5, 0.01);
  EXPECT_EQ(e.odom.x, e.map.x);
  EXPECT_EQ(e.camera_ns, captured);
}

TEST(FullFilter, ItsFirstPoseIsTheSameInBothFrames) {
  // Samples may wait for the first tick for a whole window, and the car go a long way in it.
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
  EXPECT_EQ(first.odom.x, first.map.x);
  EXPECT_EQ(first.odom.y, first.map.y);
  EXPECT_EQ(first.odom.yaw, first.map.yaw);

  // From there on each goes its way: at the car's speed.
  const Estimate second = filter.step(tick + period_ns);
  EXPECT_NEAR(std::hypot(second.odom.x - first.odom.x, second.odom.y - first.odom.y), 0.01, 1e-3);
}

TEST(FullFilter, AWheelThatIsHeardLateSetsBothFramesOffTogether) {
  FullFilter filter = started();
  for (std::int64_t k = 1; k <= 60; ++k) {
    EXPECT_FALSE(filter.step(start_ns + k * period_ns).initialised);
  }
  const std::int64_t now = start_ns + 61 * period_ns;
  for (std::int64_t age = 200; age > 0; age -= 10) {
    (void)filter.add(Measurement{Source::wheel_rear, now - age * millisecond, 2.0, 0.01});
  }
  const Estimate first = filter.step(now);
  ASSERT_TRUE(first.initialised);
  EXPECT_NEAR(first.map.x, 0.4, 0.03);
  EXPECT_EQ(first.odom.x, first.map.x);
  EXPECT_EQ(first.odom.y, first.map.y);
}

TEST(FullFilter, WithoutLeaveACameraPoseDoesNotInitialise) {
  FullFilter filter({});
  (void)filter.add(Measurement{Source::wheel_rear, start_ns, 0.0, 0.01});
  (void)filter.add(CameraPose{start_ns, start_ns, 1.0, 2.0, 0.5, 0.008, 0.008, 0.009});
  EXPECT_FALSE(filter.step(start_ns).initialised);
  const auto judgements = filter.judgements();
  const auto camera = std::ranges::find(judgements, Source::camera, &Judgement::source);
  ASSERT_NE(camera, judgements.end());
  EXPECT_EQ(camera->verdict, Verdict::source_off);
}

TEST(FullFilter, ResumesWithWhatItsPredecessorHasLearnt) {
  FullFilter before = started();
  Estimate predecessor = run(before, drive_on_a_circle(2'000 * millisecond), 400).back();
  Calibration& learnt = predecessor.calibration;
  learnt.value = {0.011, 1.004, 0.12, -0.08, 1.013, 0.007, 0.93};
  learnt.sigma = {0.001, 0.002, 0.01, 0.01, 0.001, 0.001, 0.03};

  FullFilter filter({});
  ASSERT_TRUE(filter.resume(predecessor, 0.3));
  const Calibration& resumed = filter.step(start_ns).calibration;
  for (std::size_t i = 0; i < calibration_count; ++i) {
    EXPECT_NEAR(resumed.value[i], learnt.value[i], 1e-12) << i;
    EXPECT_GE(resumed.sigma[i], learnt.sigma[i]) << i;
    EXPECT_LT(resumed.sigma[i], 1.1 * learnt.sigma[i]) << i;
  }
  EXPECT_EQ(resumed.valid, (std::uint64_t{1} << calibration_count) - 1);
}

TEST(FullFilter, ResumesInTheMiddleOfADriveAsWellAsAtItsBegin) {
  FullFilter before = started();
  const Estimate predecessor = run(before, drive_on_a_circle(500 * millisecond), 100).back();
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

TEST(FullFilter, ResumesWithoutCalibrationsThatMeanNothing) {
  FullFilter before = started();
  Estimate predecessor = run(before, drive_on_a_circle(500 * millisecond), 100).back();
  predecessor.calibration.value.fill(std::nan(""));
  predecessor.calibration.sigma = {0.001, 0.0, -1.0, 1e9, std::nan(""), 0.001, 0.0};
  FullFilter filter({});
  ASSERT_TRUE(filter.resume(predecessor, 0.3));
  const Calibration fresh = Calibration{};
  const Estimate e = filter.step(start_ns);
  EXPECT_EQ(e.calibration.value, fresh.value);
  EXPECT_EQ(e.calibration.valid, 0U);
}

TEST(FullFilter, ItsBytesAreAllThereIs) {
  // A recording keeps them, and goes on from them.
  const std::vector<Arrival> arrivals = drive_on_a_circle(1'000 * millisecond);
  FullFilter filter = started();
  (void)run(filter, arrivals, 100);
  FullFilter other({});
  static_assert(std::is_trivially_destructible_v<FullFilter>);
  std::memcpy(static_cast<void*>(&other), static_cast<const void*>(&filter), sizeof filter);
  for (std::int64_t k = 101; k <= 200; ++k) {
    for (const Arrival& arrival : arrivals) {
      if (tick_of(arrival.arrival_ns) == k) {
        hand_in(filter, arrival);
        hand_in(other, arrival);
      }
    }
    const std::int64_t now = start_ns + k * period_ns;
    expect_same_frames(filter.step(now), other.step(now));
  }
}

TEST(FullFilter, ACameraThatIsRightMovesTheMapOnceAndTheOdometryFrameNever) {
  std::vector<Arrival> arrivals = drive_on_a_circle(5'000 * millisecond);
  for (Arrival& arrival : arrivals) {
    if (arrival.camera && arrival.camera->capture_ns > start_ns + 3'000 * millisecond) {
      arrival.camera->x += 1.0;
      arrival.camera->y -= 2.0;
    }
  }
  FullFilter filter = started();
  const std::vector<Estimate> estimates = run(filter, arrivals, 1000);
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
  const Pose2 truth = moved({}, circle, static_cast<double>(last.time_ns - start_ns) * 1e-9);
  EXPECT_NEAR(last.map.x, truth.x + 1.0, 0.02);
  EXPECT_NEAR(last.map.y, truth.y - 2.0, 0.02);
}

TEST(FullFilter, AJumpThatALatePoseTakesBackIsOneMoreJump) {
  // Six poses that agree on another place; and one that was taken between them and says otherwise,
  // but comes after them.
  std::vector<Arrival> arrivals = drive_on_a_circle(2'000 * millisecond);
  const std::int64_t first = start_ns + 1'015 * millisecond;
  const std::int64_t last = first + 5 * 35 * millisecond;
  for (Arrival& arrival : arrivals) {
    if (arrival.camera && arrival.camera->capture_ns >= first &&
        arrival.camera->capture_ns <= last) {
      arrival.camera->x += 1.0;
      arrival.camera->y -= 2.0;
    }
  }
  const std::int64_t between = first + 90 * millisecond;
  const std::int64_t late = last + 60 * millisecond;
  const Pose2 truth = moved({}, circle, static_cast<double>(between - start_ns) * 1e-9);
  arrivals.push_back(
      {late, {}, CameraPose{between, late, truth.x, truth.y, truth.yaw, 0.008, 0.008, 0.009}});
  std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_ns);

  FullFilter filter = started();
  const std::vector<Estimate> estimates = run(filter, arrivals, 300);
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

TEST(FullFilter, OutliersOfTheCameraMoveNothing) {
  std::vector<Arrival> arrivals = drive_on_a_circle(5'000 * millisecond);
  FullFilter honest = started();
  const Estimate expected = run(honest, arrivals, 1000).back();
  std::mt19937 random(8);
  std::uniform_real_distribution<double> off(0.2, 1.0);
  int outliers = 0;
  for (Arrival& arrival : arrivals) {
    if (arrival.camera && random() % 10 == 0 &&
        arrival.camera->capture_ns > start_ns + 500 * millisecond) {
      arrival.camera->x += off(random);
      arrival.camera->y -= off(random);
      ++outliers;
    }
  }
  ASSERT_GT(outliers, 5);
  FullFilter filter = started();
  const Estimate e = run(filter, arrivals, 1000).back();
  EXPECT_EQ(e.reset_count, 1U);
  EXPECT_NEAR(e.map.x, expected.map.x, 0.01);
  EXPECT_NEAR(e.map.y, expected.map.y, 0.01);
}

}  // namespace
}  // namespace odomd::estimator::full_filter_test
