// One verdict for each sample, and the newest value is held; v_x of a car on a circle, from
// whichever wheels report.
#include "estimator/baselines/signals.hpp"

#include <limits>

#include "tests/gtest.hpp"

namespace odomd::estimator::signals_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t latest = 1'000;

TEST(HeldSignals, GivesEverySampleItsVerdictAndHoldsTheNewest) {
  using enum Verdict;
  constexpr Source wheel = Source::wheel_rear;
  constexpr std::int64_t end_of_time = std::numeric_limits<std::int64_t>::max();
  struct Step {
    Verdict verdict;
    double held;  ///< of the wheel, afterwards
    Measurement sample;
  };
  HeldSignals held{{}};
  EXPECT_FALSE(held[wheel].seen);
  for (const auto& [verdict, holds, sample] : {
           Step{non_finite, 0.0, {wheel, 100, nan, 0.1}},
           {gated, 0.0, {wheel, 100, 151.0, 0.1}},
           {source_off, 0.0, {Source::camera, 100, 0.0, 0.1}},
           {fused, -149.0, {wheel, 100, -149.0, 0.1}},
           {fused, 2.0, {wheel, 200, 2.0, 0.1}},
           {too_old, 2.0, {wheel, 100, 1.0, 0.1}},
           {duplicate, 2.0, {wheel, 200, 2.5, 0.1}},
           {fused, 2.0, {Source::motor, 200, 1.0, 0.1}},
           {fused, 3.0, {wheel, 300, 3.0, 0.1}},
           {fused, 1.0, {wheel, latest, 1.0, 0.1}},
           {future, 1.0, {wheel, latest + 1, 2.0, 0.1}},
           {future, 1.0, {wheel, end_of_time, 2.0, 0.1}},
       }) {
    EXPECT_EQ(held.take(sample, latest), verdict) << sample.time_ns << ' ' << sample.value;
    EXPECT_EQ(held[wheel].value, holds) << sample.time_ns << ' ' << sample.value;
    EXPECT_EQ(held[wheel].seen, holds != 0.0);
  }
  EXPECT_EQ(held[wheel].time_ns, latest);
}

TEST(HeldSignals, SigmaComesFromSampleSettingsOrDefault) {
  FilterSettings settings;
  settings.sigma[index_of(Source::motor)] = 0.7;
  HeldSignals held{settings};
  EXPECT_EQ(held.take({Source::motor, 100, 1.0, 0.0}, latest), Verdict::fused);
  EXPECT_EQ(held[Source::motor].sigma, 0.7);
  EXPECT_EQ(held.take({Source::motor, 200, 1.0, 0.2}, latest), Verdict::fused);
  EXPECT_EQ(held[Source::motor].sigma, 0.2);
  EXPECT_EQ(held[Source::steering].sigma, info_of(Source::steering).sigma);
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
  for (const Sample& s : samples)
    EXPECT_EQ(held.take({s.source, s.time_ns, s.value, 0.1}, no_limit), Verdict::fused);
  const auto speed = rear_axle_speed(car, held, turn);
  return speed ? speed->v_x : nan;
}

const double left = v_x - turn_rate * car.track_width / 2.0;
const double right = v_x + turn_rate * car.track_width / 2.0;

using enum Source;

TEST(WheelSpeed, NothingWithoutAWheel) {
  HeldSignals held{{}};
  EXPECT_FALSE(rear_axle_speed(car, held, 0.0).has_value());
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
       })
    EXPECT_NEAR(v_x_of(samples, turn), speed, 1e-15) << name;
}

TEST(WheelSpeed, PrecedenceFollowsTheDocumentation) {
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

TEST(WheelSpeed, SilentSourceIsDroppedWhileAnotherReports) {
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
  for (const double forward : {0.0, 1.0}) {
    for (const double speed : {1.0, -1.0})
      EXPECT_EQ(v_x_of({{motor, speed}, {direction, forward}}), speed);
  }
  for (const double speed : {1.0, -1.0})
    EXPECT_EQ(v_x_of({{motor, speed}, {direction, -1.0}}), -1.0);
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
