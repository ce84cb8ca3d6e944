// One corrupt sample among good ones, and the decision between two that contradict each other.
#include "estimator/ekf/plausibility.hpp"

#include <random>

#include "tests/estimator/signalled_car.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing::plausibility_test {
namespace {

TEST(Plausibility, AFirstWheelSpeedThatNoOtherConfirmsStartsNothing) {
  Car car;
  car.push(Source::wheel_rear, 100.0);
  for (int i = 0; i < 200; ++i) {
    advance(car.context, car.state, car.state.time_ns + period_ns);
    car.push(Source::wheel_rear, 0.0);
  }
  EXPECT_NEAR(car.x(), 0.0, 0.01);
  EXPECT_TRUE(car.stands());
}

TEST(Plausibility, AStillWheelHasNoVoteOnlyAgainstOneWithASmallerDeadBand) {
  State state = initial_state({});
  state.time_ns = 1'000 * estimator::testing::millisecond;
  for (const Source wheel :
       {Source::wheel_front_left, Source::wheel_front_right, Source::wheel_rear_left})
    state.reading(wheel) = {.consistent = 3, .time_ns = state.time_ns};
  const Sample trembles{.time_ns = state.time_ns,
                        .source = Source::wheel_rear_right,
                        .value = {0.05},
                        .sigma = {0.01}};
  EXPECT_EQ(count_wheels(Driven::rear, state, trembles).still, 3);
  state.standstill.dead_band[index_of(Source::wheel_rear_right)] = 0.02;
  EXPECT_EQ(count_wheels(Driven::rear, state, trembles).still, 0);
}

TEST(Plausibility, ADeadWheelIsOutvotedAfterADropOut) {
  for (const double silence : {0.1, 0.26, 0.3, 1.5}) {
    Car car = car_after(3.0, straight_at(2.0));
    const SensorValues dead = with(straight_at(2.0), Source::wheel_front_left, 0.0);
    car.drive(2.0, dead);
    car.drive(silence, {{{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}}});
    car.drive(5.0, dead);
    EXPECT_NEAR(car.v_x(), 2.0, 0.02) << silence;
    EXPECT_NEAR(car.x(), 2.0 * (10.0 + silence), 0.3) << silence;
    EXPECT_EQ(car.fused[Source::wheel_front_left], 0) << silence;
  }
}

TEST(Plausibility, ASpeedThatIsPolledOnceASecondIsFollowed) {
  Car car;
  for (int second = 0; second < 30; ++second) {
    car.drive(1.0, {{{Source::yaw_rate, 0.0}}});
    car.push(Source::motor, second < 10 ? 3.0 * second : 30.0);
  }
  EXPECT_NEAR(car.v_x(), 30.0, 0.1);
  EXPECT_NEAR(car.x(), 20.0 * 30.0 + 0.5 * 10.0 * 30.0, 80.0);
}

TEST(Plausibility, FramesThatContradictEachOtherAreNeverForced) {
  // The wheels send no messages but random frames that pass the checks.
  const SensorValues silent{{{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}}};
  int wrong = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Car car = car_after(2.0, straight_at(1.0));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-100.0, 100.0);
    for (int i = 0; i < 50; ++i) {
      car.drive(0.3, silent);
      car.push(Source::wheel_rear_left, any(random));
    }
    const double way = car.x() - 17.0;
    wrong += std::abs(way) > 3.0 * std::sqrt(car.state.covariance(at::x, at::x)) ? 1 : 0;
  }
  EXPECT_LE(wrong, 1);
}

TEST(Plausibility, ASourceNeedsConsistentSamplesAfterAGap) {
  Car car = car_after(2.0, straight_at(1.0));
  const SensorValues silent{{{Source::accel_x, 0.0}}};
  car.drive(3.0, silent);
  EXPECT_EQ(car.push(Source::yaw_rate, 9.0).verdict, Verdict::gated);
  EXPECT_EQ(car.push(Source::wheel_rear, 60.0).verdict, Verdict::gated);
  for (const Verdict verdict : {Verdict::gated, Verdict::gated, Verdict::fused}) {
    car.drive(0.01, silent);
    EXPECT_EQ(car.push(Source::yaw_rate, 0.1).verdict, verdict);
    EXPECT_EQ(car.push(Source::wheel_rear, 1.2).verdict, verdict);
  }
}

TEST(Plausibility, OneWildAccelerationIsNoInput) {
  Car car = car_at_rest(2.0);
  car.drive(5.0, straight_at(1.0));
  for (const Source source : {Source::accel_x, Source::accel_y})
    EXPECT_EQ(car.push(source, 150.0).verdict, Verdict::gated);
  EXPECT_NEAR(car.state.accel_x.value, 0.0, 1e-6);
  car.drive(0.1, straight_at(1.0));
  EXPECT_LE(car.gated[Source::accel_x], 1);
  EXPECT_EQ(car.gated[Source::accel_y], 0);
  EXPECT_NEAR(car.v_x(), 1.0, 0.01);
}

TEST(Plausibility, OneReadingOfTheGyroTurnsNoCarEvenIfItPassesTheGate) {
  for (const auto& [spike, yaw] : {std::pair(8.0, 0.005), {1.5, 0.002}}) {
    Car car = car_after(2.0, straight_at(1.0));
    for (int i = 0; i < 20; ++i) {
      car.tick(with(straight_at(1.0), Source::yaw_rate, spike));
      EXPECT_LT(std::abs(car.yaw_rate()), spike == 8.0 ? 0.02 : spike);
      car.drive(0.1, straight_at(1.0));
      EXPECT_EQ(car.gated[Source::yaw_rate], 0) << spike;
    }
    EXPECT_NEAR(car.yaw(), 0.0, yaw) << spike;
  }
}

TEST(Plausibility, LateralAccelerationsToBothSidesAreNeverForced) {
  const SensorValues values = without(straight_at(2.0), Source::accel_y);
  const auto fused_of = [&values](double first, double second) {
    Car car = car_after(2.0, values);
    int fused = 0;
    for (int i = 0; i < 20; ++i) {
      car.drive(0.1, values);
      const Judgement judgement = car.push(Source::accel_y, i % 2 == 0 ? first : second);
      fused += is_taken(judgement.verdict) ? 1 : 0;
    }
    return fused;
  };
  EXPECT_EQ(fused_of(7.7, -6.2), 0);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::plausibility_test
