// One verdict for each sample, and the newest value is held; v_x of a car on a circle, from
// whichever wheels report.
#include "estimator/baselines/signals.hpp"

#include <limits>

#include "tests/gtest.hpp"

namespace odomd::estimator::signals_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t latest = 1'000;

Verdict take(HeldSignals& held, std::int64_t time_ns, double value, double sigma = 0.1) {
  return held.take({Source::wheel_rear, time_ns, value, sigma}, latest);
}

TEST(HeldSignals, HoldsNothingAtFirst) {
  const HeldSignals held{{}};
  EXPECT_FALSE(held[Source::wheel_rear].seen);
  EXPECT_EQ(held[Source::wheel_rear].value, 0.0);
}

TEST(HeldSignals, HoldsTheNewestByItsOwnTimeInAnyOrder) {
  HeldSignals held{{}};
  EXPECT_EQ(take(held, 200, 2.0), Verdict::fused);
  EXPECT_EQ(take(held, 100, 1.0), Verdict::too_old);
  EXPECT_EQ(held[Source::wheel_rear].value, 2.0);
  EXPECT_EQ(take(held, 300, 3.0), Verdict::fused);
  EXPECT_EQ(held[Source::wheel_rear].value, 3.0);
  EXPECT_EQ(held[Source::wheel_rear].time_ns, 300);
}

TEST(HeldSignals, SameSourceAndTimeIsADuplicate) {
  HeldSignals held{{}};
  EXPECT_EQ(take(held, 200, 2.0), Verdict::fused);
  EXPECT_EQ(take(held, 200, 2.5), Verdict::duplicate);
  EXPECT_EQ(held[Source::wheel_rear].value, 2.0);
  EXPECT_EQ(held.take({Source::motor, 200, 1.0, 0.1}, latest), Verdict::fused);
}

TEST(HeldSignals, NonFiniteNumbersChangeNothing) {
  HeldSignals held{{}};
  for (const double value : {nan, infinity, -infinity}) {
    EXPECT_EQ(take(held, 100, value), Verdict::non_finite);
  }
  for (const double sigma : {nan, infinity, -0.1}) {
    EXPECT_EQ(take(held, 100, 1.0, sigma), Verdict::non_finite);
  }
  EXPECT_FALSE(held[Source::wheel_rear].seen);
}

TEST(HeldSignals, SampleAheadOfTheLimitIsFromTheFuture) {
  HeldSignals held{{}};
  EXPECT_EQ(take(held, latest, 1.0), Verdict::fused);
  EXPECT_EQ(take(held, latest + 1, 2.0), Verdict::future);
  EXPECT_EQ(take(held, std::numeric_limits<std::int64_t>::max(), 2.0), Verdict::future);
  EXPECT_EQ(held[Source::wheel_rear].value, 1.0);
}

TEST(HeldSignals, WhatNoCarDoesIsGated) {
  HeldSignals held{{}};
  EXPECT_EQ(take(held, 100, 151.0), Verdict::gated);
  EXPECT_EQ(take(held, 100, -1e300), Verdict::gated);
  EXPECT_EQ(held.take({Source::steering, 100, 1.5707, 0.1}, latest), Verdict::gated);
  EXPECT_EQ(held.take({Source::direction, 100, -2.0, 0.1}, latest), Verdict::gated);
  EXPECT_EQ(take(held, 100, -149.0), Verdict::fused);
}

TEST(HeldSignals, CameraAndUnknownSourcesAreNoSignals) {
  HeldSignals held{{}};
  EXPECT_EQ(held.take({Source::camera, 100, 0.0, 0.1}, latest), Verdict::source_off);
  EXPECT_EQ(held.take({Source::count, 100, 0.0, 0.1}, latest), Verdict::source_off);
  EXPECT_EQ(held.take({static_cast<Source>(200), 100, 0.0, 0.1}, latest), Verdict::source_off);
}

TEST(HeldSignals, SigmaIsTheSamplesOwnElseTheSettingsElseTheDefault) {
  FilterSettings settings;
  settings.sigma[index_of(Source::motor)] = 0.7;
  HeldSignals held{settings};
  EXPECT_EQ(held.take({Source::motor, 100, 1.0, 0.0}, latest), Verdict::fused);
  EXPECT_EQ(held[Source::motor].sigma, 0.7);
  EXPECT_EQ(held.take({Source::motor, 200, 1.0, 0.2}, latest), Verdict::fused);
  EXPECT_EQ(held[Source::motor].sigma, 0.2);
  EXPECT_EQ(held[Source::steering].sigma,
            default_sigma[static_cast<std::size_t>(Source::steering)]);
}

constexpr std::int64_t second = 1'000'000'000;
constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

const Vehicle car;
// A left turn without slip: the middle of the rear axle moves at v_x, the circle's centre is on the
// left.
constexpr double v_x = 1.5;
constexpr double delta = 0.3;
const double turn_rate = v_x * std::tan(delta) / car.wheelbase();

struct Sample {
  Source source;
  double value;
  std::int64_t time_ns = second;
};

double v_x_of(const std::vector<Sample>& samples, double turn = turn_rate) {
  HeldSignals held{{}};
  for (const Sample& s : samples) {
    EXPECT_EQ(held.take({s.source, s.time_ns, s.value, 0.1}, no_limit), Verdict::fused);
  }
  const auto speed = rear_axle_speed(car, held, turn);
  return speed ? speed->v_x : std::numeric_limits<double>::quiet_NaN();
}

const double left = v_x - turn_rate * car.track_width / 2.0;
const double right = v_x + turn_rate * car.track_width / 2.0;

using enum Source;

TEST(WheelSpeed, NothingWithoutAWheel) {
  EXPECT_FALSE(rear_axle_speed(car, HeldSignals{{}}, 0.0).has_value());
  HeldSignals held{{}};
  held.take({accel_x, 1, 1.0, 0.1}, no_limit);
  EXPECT_FALSE(rear_axle_speed(car, held, 0.0).has_value());
}

TEST(WheelSpeed, AnyWheelOfACarOnACircleGivesTheSpeedOfItsRearAxle) {
  // The front axle's middle moves along δ. A front wheel moves along the car's axis like the rear
  // wheel on its side, and along its own direction faster by the factor 1 / cos δ.
  const double faster = 1.0 / std::cos(delta);
  const double front = v_x * faster;
  struct Case {
    const char* name;
    std::vector<Sample> samples;
    double turn = turn_rate;
    double speed = v_x;
  };
  for (const auto& [name, samples, turn, speed] : {
           Case{"the mean of both rear wheels needs no yaw rate",
                {{wheel_rear_left, left}, {wheel_rear_right, right}},
                0.0},
           {"rear left", {{wheel_rear_left, left}}},
           {"rear right", {{wheel_rear_right, right}}},
           {"both front wheels",
            {{wheel_front_left, front - 0.1}, {wheel_front_right, front + 0.1}, {steering, delta}}},
           {"front left", {{wheel_front_left, left * faster}, {steering, delta}}},
           {"front right", {{wheel_front_right, right * faster}, {steering, delta}}},
           // In reverse on the same circle: v_x and ψ̇ change sign together.
           {"in reverse", {{wheel_rear_left, left}, {direction, -1.0}}, -turn_rate, -v_x},
       }) {
    EXPECT_NEAR(v_x_of(samples, turn), speed, 1e-15) << name;
  }
}

TEST(WheelSpeed, PrecedenceIsThatOfTheDocumentation) {
  EXPECT_EQ(v_x_of({{wheel_rear_left, 1.0},
                    {wheel_rear_right, 1.0},
                    {wheel_rear, 2.0},
                    {motor, 3.0},
                    {wheel_front_left, 4.0},
                    {wheel_front_right, 4.0}}),
            1.0);
  EXPECT_EQ(v_x_of({{wheel_rear_left, 1.0}, {wheel_rear, 2.0}, {motor, 3.0}}), 2.0);
  EXPECT_EQ(v_x_of({{wheel_rear_left, 1.0}, {motor, 3.0}}, 0.0), 1.0);
  EXPECT_EQ(v_x_of({{motor, 3.0}, {wheel_front_left, 4.0}, {wheel_front_right, 4.0}}), 3.0);
}

TEST(WheelSpeed, SilentSourceFallsAwayWhileAnotherSpeaks) {
  const std::int64_t later = second + second / 2;
  EXPECT_EQ(v_x_of({{wheel_rear, 1.0, second}, {motor, 3.0, later}}), 1.0);
  EXPECT_EQ(v_x_of({{wheel_rear, 1.0, second}, {motor, 3.0, later + 1}}), 3.0);
  // One wheel of the pair is dead: the other is corrected for the turn.
  EXPECT_NEAR(v_x_of({{wheel_rear_left, 9.0, second}, {wheel_rear_right, right, 2 * second}}), v_x,
              1e-15);
}

TEST(WheelSpeed, LastOneIsHeldWhenAllAreSilent) {
  EXPECT_EQ(v_x_of({{motor, 3.0, second}, {steering, 0.1, 100 * second}}), 3.0);
}

TEST(WheelSpeed, DirectionGivesUnsignedSpeedsTheirSign) {
  EXPECT_EQ(v_x_of({{motor, 1.0}, {direction, -1.0}}), -1.0);
  EXPECT_EQ(v_x_of({{motor, -1.0}, {direction, -1.0}}), -1.0);
  EXPECT_EQ(v_x_of({{motor, 1.0}, {direction, 0.0}}), 1.0);
  EXPECT_EQ(v_x_of({{motor, 1.0}, {direction, 1.0}}), 1.0);
  EXPECT_EQ(v_x_of({{motor, -1.0}, {direction, 1.0}}), -1.0);
}

TEST(WheelSpeed, MeanOfTwoIsMoreCertainThanOne) {
  HeldSignals held{{}};
  held.take({wheel_rear_left, 1, 1.0, 0.3}, no_limit);
  EXPECT_DOUBLE_EQ(rear_axle_speed(car, held, 0.0)->sigma, 0.3);
  held.take({wheel_rear_right, 1, 1.0, 0.4}, no_limit);
  EXPECT_DOUBLE_EQ(rear_axle_speed(car, held, 0.0)->sigma, 0.25);
}

}  // namespace
}  // namespace odomd::estimator::signals_test
