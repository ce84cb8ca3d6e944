// Properties of every model behind the common interface.
#include "estimator/filter.hpp"

#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>

#include "drive.hpp"
#include "tests/allocation_count.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::filter_test {
namespace {

using testing::Drive;
using testing::period_ns;
using testing::Samples;
using testing::start;

constexpr std::int64_t millisecond = 1'000'000;

class EveryModel : public ::testing::TestWithParam<Model> {};
INSTANTIATE_TEST_SUITE_P(, EveryModel,
                         ::testing::Values(Model::kinematic, Model::kinematic_printed, Model::full,
                                           Model::paper, Model::inertial),
                         [](const auto& model) {
                           return std::string(model_names[static_cast<std::size_t>(model.param)]);
                         });

/// A slalom, with all signals of a car.
Samples slalom(int tick) {
  const double t = 0.005 * tick;
  const double delta = 0.25 * std::sin(2.0 * t);
  const double speed = 1.2 + 0.4 * std::sin(0.5 * t);
  return {.speed = speed,
          .steering = delta,
          .yaw_rate = speed * std::tan(delta) / 0.26,
          .accel_x = 0.2 * std::cos(0.5 * t)};
}

Drive slalom_for(Model model, int ticks) {
  Drive drive = start(model);
  for (int i = 0; i < ticks; ++i) {
    drive.tick(slalom(i));
  }
  return drive;
}

/// Fused, or left for the step to judge.
bool taken(std::optional<Verdict> verdict) {
  return verdict.value_or(Verdict::fused) == Verdict::fused;
}

void expect_same_bits(const Estimate& a, const Estimate& b) {
  EXPECT_EQ(a.time_ns, b.time_ns);
  EXPECT_EQ(a.map.x, b.map.x);
  EXPECT_EQ(a.map.y, b.map.y);
  EXPECT_EQ(a.map.yaw, b.map.yaw);
  EXPECT_EQ(a.odom.x, b.odom.x);
  EXPECT_EQ(a.v_x, b.v_x);
  EXPECT_EQ(a.v_y, b.v_y);
  EXPECT_EQ(a.yaw_rate, b.yaw_rate);
  EXPECT_EQ(a.yaw_accel, b.yaw_accel);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.velocity_covariance, b.velocity_covariance);
  EXPECT_EQ(a.mode, b.mode);
  EXPECT_EQ(a.reset_count, b.reset_count);
}

TEST_P(EveryModel, IsInitialisedByAPoseAndAWheelSpeed) {
  Drive no_pose = start(GetParam(), {}, std::nullopt);
  EXPECT_FALSE(no_pose.ticks(100, {.speed = 1.0, .steering = 0.1}).initialised);
  EXPECT_EQ(no_pose.last.mode, Mode::initialising);

  Drive no_wheel = start(GetParam(), {}, Pose2{1.0, 2.0, 3.0});
  EXPECT_FALSE(no_wheel.ticks(100, {.steering = 0.1, .yaw_rate = 0.5}).initialised);
  EXPECT_EQ(no_wheel.last.map.x, 1.0);
  no_wheel.tick({.speed = 1.0});
  // The full filter needs a second speed to confirm the first.
  EXPECT_TRUE(no_wheel.tick({.speed = 1.0}).initialised);
  EXPECT_EQ(no_wheel.last.reset_count, 1U);
}

TEST_P(EveryModel, PoseSetLateStartsThere) {
  Drive drive = start(GetParam(), {}, std::nullopt);
  drive.ticks(100, {.speed = 1.0, .steering = 0.2});
  set_initial_pose(drive.filter, {4.0, 5.0, 6.0});
  const Estimate e = drive.tick({.speed = 1.0, .steering = 0.2});
  EXPECT_TRUE(e.initialised);
  EXPECT_NEAR(e.map.x, 4.0, 0.01);
  EXPECT_NEAR(e.map.y, 5.0, 0.01);
  EXPECT_NEAR(e.map.x, e.odom.x, 1e-4);
  EXPECT_EQ(e.reset_count, 1U);
}

TEST_P(EveryModel, PoseSetLateIsKeptWhenOlderSamplesArrive) {
  Drive drive = start(GetParam(), {}, std::nullopt);
  drive.ticks(100, {.speed = 1.0});
  set_initial_pose(drive.filter, {4.0, 5.0, 0.0});
  for (int i = 0; i < 10; ++i) {
    add(drive.filter, Measurement{Source::yaw_rate, drive.now_ns - 10 * millisecond, 0.0, 0.01});
    const Estimate e = drive.tick({.speed = 1.0});
    ASSERT_TRUE(e.initialised);
    EXPECT_NEAR(e.map.x, 4.0, 0.1);
    EXPECT_NEAR(e.map.y, 5.0, 0.1);
  }
}

TEST_P(EveryModel, NonFiniteInitialPoseIsNotTaken) {
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
    const CameraPose camera{
        drive.now_ns - 40 * millisecond, drive.now_ns, 2.0, 3.0, 1.0, 0.01, 0.01, 0.01};
    EXPECT_TRUE(taken(add(drive.filter, camera)));
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

TEST_P(EveryModel, GivesTheSameBitsForTheSameInputs) {
  expect_same_bits(slalom_for(GetParam(), 2000).last, slalom_for(GetParam(), 2000).last);
}

TEST_P(EveryModel, CopyGoesOnAsTheOriginal) {
  Drive drive = slalom_for(GetParam(), 500);
  Drive copy = drive;
  for (int i = 500; i < 1000; ++i) {
    expect_same_bits(drive.tick(slalom(i)), copy.tick(slalom(i)));
  }
}

TEST_P(EveryModel, OrderOfArrivalWithinATickChangesNoBit) {
  Drive forward = start(GetParam());
  Drive backward = start(GetParam());
  for (int i = 0; i < 1000; ++i) {
    const Samples s = slalom(i);
    const std::int64_t now = forward.now_ns;
    std::vector<Measurement> samples{
        {Source::wheel_rear, now + 1 * millisecond, *s.speed - 0.1, 0.0},
        {Source::steering, now + 2 * millisecond, *s.steering, 0.0},
        {Source::yaw_rate, now + 3 * millisecond, *s.yaw_rate, 0.0},
        {Source::wheel_rear, now + 4 * millisecond, *s.speed, 0.0}};
    for (const Measurement& sample : samples) add(forward.filter, sample);
    std::reverse(samples.begin(), samples.end());
    for (const Measurement& sample : samples) add(backward.filter, sample);
    expect_same_bits(forward.tick({}), backward.tick({}));
  }
}

TEST_P(EveryModel, MicrosecondOfShiftMovesNothing) {
  Drive on_time = start(GetParam());
  Drive shifted = start(GetParam());
  for (int i = 0; i < 2000; ++i) {
    on_time.tick(slalom(i));
    // Ticks alternate between a microsecond early and late, with their samples and camera poses.
    shifted.now_ns = on_time.now_ns - period_ns + (i % 2 == 0 ? 1000 : -1000);
    shifted.tick(slalom(i));
    if (i > 100 && i % 7 == 0) {
      for (Drive* drive : {&on_time, &shifted}) {
        const Pose2 truth = on_time.last.map;
        const CameraPose camera{drive->now_ns - 100 * millisecond,
                                drive->now_ns,
                                truth.x,
                                truth.y,
                                truth.yaw,
                                0.5,
                                0.5,
                                0.5};
        EXPECT_TRUE(taken(add(drive->filter, camera)));
      }
    }
  }
  EXPECT_NEAR(on_time.last.map.x, shifted.last.map.x, 1e-4);
  EXPECT_NEAR(on_time.last.map.y, shifted.last.map.y, 1e-4);
  EXPECT_NEAR(on_time.last.map.yaw, shifted.last.map.yaw, 1e-4);
}

TEST_P(EveryModel, SkippedTicksAreMadeUpForWithTheInputsHeld) {
  const Samples steady{.speed = 1.0, .steering = 0.1, .yaw_rate = 0.38, .accel_x = 0.0};
  Drive whole = start(GetParam());
  whole.ticks(100, steady);
  Drive gappy = whole;
  const Estimate e = whole.ticks(50, steady);
  gappy.now_ns += 49 * period_ns;
  const Estimate made_up = gappy.tick(steady);
  if (GetParam() == Model::full) {  // every sample corrects it, and the gap had none
    EXPECT_NEAR(made_up.map.x, e.map.x, 1e-3);
    EXPECT_NEAR(made_up.map.y, e.map.y, 1e-3);
    EXPECT_NEAR(made_up.odom.x, e.odom.x, 1e-3);
    EXPECT_GE(made_up.covariance[0], e.covariance[0]);
    return;
  }
  expect_same_bits(made_up, e);
}

TEST_P(EveryModel, MakesUpForASecondAtMostAndOwnsToTheRest) {
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
        std::numeric_limits<std::int64_t>::min()}) {
    expect_same_bits(step(drive.filter, tick), last);
  }
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

TEST_P(EveryModel, ResumesWhereThePredecessorWouldBe) {
  Drive predecessor = start(GetParam());
  const Samples steady{.speed = 1.0, .steering = 0.1, .yaw_rate = 0.38, .accel_x = 0.0};
  const Estimate last = predecessor.ticks(400, steady);

  Drive drive = start(GetParam(), {}, std::nullopt);
  ASSERT_TRUE(resume(drive.filter, last, 0.2));
  const Estimate e = drive.tick({});
  EXPECT_TRUE(e.initialised);
  EXPECT_EQ(e.reset_count, last.reset_count + 1);
  const Estimate truth = predecessor.ticks(41, steady);
  EXPECT_NEAR(e.map.x, truth.map.x, 0.01);
  EXPECT_NEAR(e.map.y, truth.map.y, 0.01);
  EXPECT_NEAR(e.odom.x, truth.odom.x, 0.01);
  EXPECT_NEAR(e.v_x, truth.v_x, 0.1);
  EXPECT_GT(e.covariance[0], last.covariance[0]);
  EXPECT_GT(e.covariance[5], last.covariance[5]);
  EXPECT_TRUE(is_positive_definite(e.covariance));
}

TEST_P(EveryModel, CovarianceGrowsWithTheGap) {
  const Estimate last = slalom_for(GetParam(), 400).last;
  double before = 0.0;
  for (const double gap : {0.0, 0.1, 0.5, 2.0}) {
    Drive drive = start(GetParam(), {}, std::nullopt);
    ASSERT_TRUE(resume(drive.filter, last, gap));
    const double variance = drive.tick({}).covariance[0];
    EXPECT_GT(variance, before);
    before = variance;
  }
}

TEST_P(EveryModel, ResumeKeepsThePoseInTheMapAndInTheOdometryFrameApart) {
  Estimate last = slalom_for(GetParam(), 400).last;
  last.map = {10.0, 20.0, 1.0};
  last.v_x = last.v_y = last.yaw_rate = 0.0;
  Drive drive = start(GetParam(), {}, std::nullopt);
  ASSERT_TRUE(resume(drive.filter, last, 1.0));
  const Estimate e = drive.tick({});
  EXPECT_NEAR(e.map.x, 10.0, 0.01);
  EXPECT_NEAR(e.odom.x, last.odom.x, 0.01);
}

TEST_P(EveryModel, DoesNotResumeFromWhatIsNotUsable) {
  const Estimate good = slalom_for(GetParam(), 400).last;
  Drive drive = start(GetParam(), {}, std::nullopt);
  Estimate bad = good;
  bad.initialised = false;
  EXPECT_FALSE(resume(drive.filter, bad, 0.1));
  bad = good;
  bad.model_fault = true;
  EXPECT_FALSE(resume(drive.filter, bad, 0.1));
  bad = good;
  bad.map.x = std::nan("");
  EXPECT_FALSE(resume(drive.filter, bad, 0.1));
  bad = good;
  bad.covariance = {};
  EXPECT_FALSE(resume(drive.filter, bad, 0.1));
  for (const double impossible : {1e4, -1e300}) {  // finite, but impossible for a car
    bad = good;
    bad.v_x = impossible;
    EXPECT_FALSE(resume(drive.filter, bad, 0.1)) << impossible;
    bad = good;
    bad.yaw_rate = impossible;
    EXPECT_FALSE(resume(drive.filter, bad, 0.1)) << impossible;
  }
  bad = good;
  bad.covariance[0] = 1e300;
  EXPECT_FALSE(resume(drive.filter, bad, 0.1));
  EXPECT_FALSE(resume(drive.filter, good, -0.1));
  EXPECT_FALSE(resume(drive.filter, good, std::nan("")));
  EXPECT_FALSE(drive.tick({.speed = 1.0}).initialised);
  bad = good;
  bad.velocity_covariance = {};
  EXPECT_TRUE(resume(drive.filter, bad, 0.1));
  EXPECT_TRUE(is_positive_definite(drive.tick({.speed = 1.0}).covariance));
}

TEST_P(EveryModel, TakesNothingFromTheHeap) {
  Drive drive = slalom_for(GetParam(), 300);
  const std::size_t before = allocation_count();
  for (int i = 300; i < 900; ++i) {
    if (i % 7 == 0) {
      const Pose2 map = drive.last.map;
      add(drive.filter,
          CameraPose{drive.now_ns, drive.now_ns, map.x, map.y, map.yaw, 0.1, 0.1, 0.1});
    }
    drive.tick(slalom(i));
  }
  EXPECT_EQ(allocation_count(), before);
}

TEST_P(EveryModel, CovariancesStayPositiveDefiniteThroughAWildDrive) {
  Drive drive = start(GetParam());
  for (int i = 0; i < 20'000; ++i) {
    const double t = 0.005 * i;
    const Samples wild{.speed = 5.0 + 5.0 * std::sin(t),
                       .steering = 0.6 * std::sin(7.0 * t),
                       .yaw_rate = 10.0 * std::sin(13.0 * t),
                       .accel_x = 20.0 * std::cos(3.0 * t)};
    const Estimate e = drive.tick(wild);
    ASSERT_TRUE(is_positive_definite(e.covariance)) << t;
    ASSERT_TRUE(is_positive_definite(e.velocity_covariance)) << t;
    ASSERT_TRUE(std::isfinite(e.map.x) && std::isfinite(e.v_y) && std::isfinite(e.yaw_accel));
  }
}

/// Numbers that a broken sensor or a hostile sender might send.
class Junk {
 public:
  double number() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const std::array<double, 12> unusual{0.0,       -0.0,         1e-308, 1e308, -1e308, infinity,
                                         -infinity, std::nan(""), 1e-3,   150.0, -1.4,   1e7};
    return pick(3) == 0 ? unusual[pick(unusual.size())]
                        : std::normal_distribution<>{0.0, 2.0}(random_);
  }
  std::int64_t time(std::int64_t now) {
    if (pick(10) == 0) {
      return static_cast<std::int64_t>(random_());
    }
    return now + std::uniform_int_distribution<std::int64_t>{-300 * millisecond,
                                                             20 * millisecond}(random_);
  }
  std::size_t pick(std::size_t count) { return random_() % count; }

 private:
  std::mt19937_64 random_{2026};
};

TEST_P(EveryModel, NoInputLeavesAnEstimateThatIsNotFiniteOrASampleWithoutVerdict) {
  Junk junk;
  FilterSettings settings;
  settings.initialise_from_camera = true;
  Drive drive = start(GetParam(), settings, std::nullopt);
  std::array<int, verdict_count> verdicts{};
  int offered = 0;
  // A step of the full filter replays a window full of invalid samples.
  const int steps = GetParam() == Model::full ? 5'000 : 20'000;
  for (int i = 0; i < steps; ++i) {
    for (std::size_t n = junk.pick(8); n > 0; --n) {
      const Measurement sample{static_cast<Source>(junk.pick(source_count + 2)),
                               junk.time(drive.now_ns), junk.number(), std::abs(junk.number()),
                               junk.pick(2) == 0 ? 0 : junk.time(drive.now_ns)};
      ++offered;
      if (const auto verdict = add(drive.filter, sample)) {
        ++verdicts.at(static_cast<std::size_t>(*verdict));
      }
    }
    if (junk.pick(5) == 0) {
      const CameraPose camera{junk.time(drive.now_ns), junk.time(drive.now_ns),
                              junk.number(),           junk.number(),
                              junk.number(),           std::abs(junk.number()),
                              std::abs(junk.number()), std::abs(junk.number())};
      ++offered;
      if (const auto verdict = add(drive.filter, camera)) {
        ++verdicts.at(static_cast<std::size_t>(*verdict));
      }
    }
    // Sometimes a gap of seconds.
    drive.now_ns += static_cast<std::int64_t>(junk.pick(i % 1000 == 999 ? 1000 : 3)) * period_ns;
    const Estimate e = drive.tick({});
    for (const Judgement& judgement : judgements(drive.filter)) {
      verdicts.at(static_cast<std::size_t>(judgement.verdict)) += static_cast<int>(judgement.count);
    }
    ASSERT_TRUE(is_finite(e.map) && is_finite(e.odom) && is_finite(e.last_jump)) << i;
    ASSERT_TRUE(is_finite(BodyVelocity{e.v_x, e.v_y, e.yaw_rate})) << i;
    ASSERT_TRUE(is_finite(BodyVelocity{e.v_x_dot, e.v_y_dot, e.yaw_accel})) << i;
    ASSERT_TRUE(is_finite(e.covariance) && is_positive_definite(e.covariance)) << i;
    ASSERT_TRUE(is_finite(e.velocity_covariance) && is_positive_definite(e.velocity_covariance))
        << i;
    ASSERT_FALSE(std::isnan(e.camera_test_ratio)) << i;
  }
  for (int i = 0; i < 100; ++i) {
    drive.tick({});
    for (const Judgement& judgement : judgements(drive.filter)) {
      verdicts.at(static_cast<std::size_t>(judgement.verdict)) += static_cast<int>(judgement.count);
    }
  }
  EXPECT_EQ(std::accumulate(verdicts.begin(), verdicts.end(), 0), offered);
  for (const Verdict verdict : {Verdict::fused, Verdict::gated, Verdict::too_old, Verdict::future,
                                Verdict::non_finite, Verdict::source_off}) {
    EXPECT_GT(verdicts[static_cast<std::size_t>(verdict)], 0)
        << verdict_names[static_cast<std::size_t>(verdict)];
  }
}

TEST_P(EveryModel, TheNoiseOfASourceIsEstimatedByTheFullFilter) {
  FilterSettings settings;
  settings.sigma[index_of(Source::yaw_rate)] = 0.04;
  Drive drive = start(GetParam(), settings);
  std::mt19937 random(5);
  const auto drive_with = [&](double speed, double gyro_noise) {
    std::normal_distribution<double> noise(0.0, gyro_noise);
    for (int i = 0; i < 1000; ++i) {
      drive.tick({.speed = speed, .steering = 0.0, .yaw_rate = noise(random)});
    }
  };
  drive_with(0.0, 0.008);
  const SourceNoise standing = noise(drive.filter, Source::yaw_rate);
  drive_with(1.0, 0.02);
  const SourceNoise gyro = noise(drive.filter, Source::yaw_rate);
  const SourceNoise wheel = noise(drive.filter, Source::wheel_rear);
  for (const Source silent : {Source::accel_x, Source::motor, Source::steering, Source::camera}) {
    EXPECT_FALSE(noise(drive.filter, silent).estimated()) << source_names[index_of(silent)];
  }
  if (GetParam() != Model::full) {
    EXPECT_FALSE(gyro.estimated());
    EXPECT_FALSE(wheel.estimated());
    return;
  }
  EXPECT_EQ(gyro.stated, 0.04);
  EXPECT_NEAR(standing.at_rest, 0.008, 0.001);
  EXPECT_NEAR(gyro.at_rest, standing.at_rest, 0.1 * standing.at_rest) << "kept on the move";
  EXPECT_NEAR(gyro.moving, 0.02, 0.002);
  EXPECT_EQ(wheel.stated, default_sigma[index_of(Source::wheel_rear)]);
  EXPECT_GT(wheel.speed_share, 0.0);
  EXPECT_EQ(wheel.moving, 0.0);
}

TEST_P(EveryModel, StandingCarDoesNotAccelerate) {
  Drive drive = start(GetParam());
  const Estimate e =
      drive.ticks(400, {.speed = 0.0, .steering = 0.4, .yaw_rate = 0.012, .accel_x = 0.3});
  EXPECT_EQ(e.mode, Mode::standstill);
  EXPECT_EQ(e.v_x_dot, 0.0);
  EXPECT_EQ(e.v_y_dot, 0.0);
  EXPECT_EQ(e.yaw_accel, 0.0);
}

TEST(MakeFilter, RefusesImpossibleSettingsByName) {
  const auto message = [](const FilterSettings& settings) -> std::string {
    try {
      (void)make_filter(Model::paper, settings);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({}), "");
  FilterSettings settings;
  settings.vehicle.mass = 0.0;
  EXPECT_NE(message(settings).find("vehicle.mass"), std::string::npos);
  settings = {};
  settings.period_s = std::nan("");
  EXPECT_NE(message(settings).find("period"), std::string::npos);
  settings = {};
  settings.period_s = 2.0;
  EXPECT_NE(message(settings).find("period"), std::string::npos);
  settings = {};
  settings.sigma[static_cast<std::size_t>(Source::motor)] = std::nan("");
  EXPECT_NE(message(settings).find("motor"), std::string::npos);
  settings = {};
  settings.paper.R[1] = -1.0;
  EXPECT_NE(message(settings).find("R[1]"), std::string::npos);
  EXPECT_THROW((void)make_filter(static_cast<Model>(9), {}), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::estimator::filter_test
