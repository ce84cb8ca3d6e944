// One sample after the other into a state: which are believed, and what becomes of a sensor that
// keeps disagreeing with the others.
#include "estimator/full/take.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>

#include "states.hpp"

namespace odomd::estimator::full::take_test {
namespace {

constexpr std::int64_t millisecond = 1'000'000;
constexpr std::int64_t period_ns = 5 * millisecond;

/// What the sensors say; what is not driven says nothing.
struct Says {
  std::map<Source, double> signals;
};

/// A car on its way, a tick at a time; counts what was fused and gated of each source.
class Car {
 public:
  Car() {
    state.time_ns = 1'000 * millisecond;
    state.located = true;
    Vector sigma;
    sigma << 0.05, 0.05, 0.05, 1.0, 0.5, 1.0, 1.5, 1.5, 0.3, 0.02, 0.15, 0.03, 0.02, 0.3, 0.03;
    state.covariance.diagonal() = sigma.array().square();
  }

  Judgement say(Source source, double value) {
    constexpr std::array<double, source_count> sigmas{0.01, 0.1,  0.1,  0.01,  0.01, 0.01,
                                                      0.01, 0.01, 0.01, 0.005, 1.0,  1.0};
    const Judgement judgement = take(context, state,
                                     {.time_ns = state.time_ns,
                                      .source = source,
                                      .value = {value},
                                      .sigma = {sigmas[static_cast<std::size_t>(source)]}});
    ++(judgement.verdict == Verdict::fused ? fused : gated)[source];
    return judgement;
  }

  void tick(const Says& says) {
    advance(context, state, state.time_ns + period_ns);
    for (const auto& [source, value] : says.signals) {
      const bool wheel = source >= Source::wheel_front_left && source <= Source::motor;
      if (!wheel || state.time_ns % (2 * period_ns) == 0) {
        say(source, value);
      }
    }
    ASSERT_TRUE(testing::is_covariance(state.covariance));
  }

  /// For so long; the counts begin anew.
  void drive(double seconds, const Says& says) {
    fused.clear();
    gated.clear();
    for (int i = 0; i < static_cast<int>(std::lround(200.0 * seconds)); ++i) {
      tick(says);
    }
  }

  Context context;
  State state;
  std::map<Source, int> fused;
  std::map<Source, int> gated;
};

Says straight_at(double speed) {
  return {{{Source::yaw_rate, 0.0},
           {Source::accel_x, 0.0},
           {Source::accel_y, 0.0},
           {Source::steering, 0.0},
           {Source::wheel_front_left, speed},
           {Source::wheel_front_right, speed},
           {Source::wheel_rear_left, speed},
           {Source::wheel_rear_right, speed}}};
}

Says with(Says says, Source source, double value) {
  says.signals[source] = value;
  return says;
}

Says without(Says says, Source source) {
  says.signals.erase(source);
  return says;
}

TEST(Take, TheFirstWheelSpeedThatIsConfirmedStartsTheMotion) {
  Car car;
  car.drive(0.1, without(without(without(without(straight_at(2.0), Source::wheel_front_left),
                                         Source::wheel_front_right),
                                 Source::wheel_rear_left),
                         Source::wheel_rear_right));
  EXPECT_FALSE(car.state.moving);
  EXPECT_EQ(car.state.mean[at::x], 0.0);
  EXPECT_EQ(car.say(Source::wheel_rear, 2.0).verdict, Verdict::fused);
  EXPECT_FALSE(car.state.moving);
  EXPECT_EQ(car.say(Source::wheel_rear_left, 2.0).verdict, Verdict::fused);
  EXPECT_TRUE(car.state.moving);
  EXPECT_NEAR(car.state.mean[at::v_x], 2.0, 1e-9);
}

TEST(Take, TheWayBetweenTheFirstTwoWheelSpeedsCounts) {
  Car car;
  car.say(Source::wheel_rear, 10.0);
  car.drive(0.02, {});
  car.say(Source::wheel_rear, 10.0);
  EXPECT_NEAR(car.state.mean[at::x], 0.2, 1e-9);
}

TEST(Take, AFirstWheelSpeedThatNoOtherConfirmsStartsNothing) {
  Car car;
  car.say(Source::wheel_rear, 100.0);
  for (int i = 0; i < 200; ++i) {
    advance(car.context, car.state, car.state.time_ns + period_ns);
    car.say(Source::wheel_rear, 0.0);
  }
  EXPECT_NEAR(car.state.mean[at::x], 0.0, 0.01);
  EXPECT_TRUE(car.state.rest.standing);
}

TEST(Take, NothingIsGatedOnAnHonestDrive) {
  Car car;
  car.drive(5.0, straight_at(1.5));
  EXPECT_TRUE(car.gated.empty());
  EXPECT_NEAR(car.state.mean[at::v_x], 1.5, 0.01);
  EXPECT_NEAR(car.state.mean[at::x], 7.5, 0.05);
}

TEST(Take, AWheelThatSpinsIsLeftOutWhileOthersRoll) {
  Car car;
  car.drive(2.0, straight_at(1.0));
  const double x = car.state.mean[at::x];
  car.drive(2.0, with(straight_at(1.0), Source::wheel_rear_left, 3.0));
  EXPECT_EQ(car.fused[Source::wheel_rear_left], 0);
  EXPECT_EQ(car.gated[Source::wheel_rear_right], 0);
  EXPECT_EQ(car.gated[Source::wheel_front_left], 0);
  EXPECT_NEAR(car.state.mean[at::v_x], 1.0, 0.02);
  EXPECT_NEAR(car.state.mean[at::x] - x, 2.0, 0.03);
  // Rolling again, it counts again.
  car.drive(0.5, straight_at(1.0));
  EXPECT_EQ(car.gated[Source::wheel_rear_left], 0);
}

TEST(Take, AWheelThatIsLockedIsLeftOutWhileOthersRoll) {
  Car car;
  car.drive(2.0, straight_at(1.0));
  const double x = car.state.mean[at::x];
  car.drive(2.0, with(straight_at(1.0), Source::wheel_front_right, 0.0));
  EXPECT_EQ(car.fused[Source::wheel_front_right], 0);
  EXPECT_FALSE(car.state.rest.standing);
  EXPECT_NEAR(car.state.mean[at::x] - x, 2.0, 0.03);
}

TEST(Take, AllWheelsTogetherAreBelievedAfterAWhile) {
  Car car;
  car.drive(2.0, straight_at(1.0));
  car.drive(0.2, straight_at(3.0));
  EXPECT_NEAR(car.state.mean[at::v_x], 1.0, 0.05);
  EXPECT_EQ(car.fused[Source::wheel_rear_left] + car.fused[Source::wheel_front_left], 0);
  car.drive(0.15, straight_at(3.0));
  EXPECT_NEAR(car.state.mean[at::v_x], 3.0, 0.1);
  EXPECT_GT(car.fused[Source::wheel_rear_left], 0);
  car.drive(1.0, straight_at(3.0));
  EXPECT_TRUE(car.gated.empty() || car.gated[Source::wheel_rear_left] == 0);
}

TEST(Take, AGyroThatInsistsIsBelievedAfterAMoment) {
  // Spun on the spot by a bump: no wheel and no steering told of it.
  Car car;
  car.drive(2.0, straight_at(1.0));
  const Says spun = without(with(straight_at(1.0), Source::yaw_rate, 3.0), Source::accel_y);
  car.drive(0.04, spun);
  EXPECT_EQ(car.fused[Source::yaw_rate], 0);
  EXPECT_NEAR(car.state.mean[at::yaw_rate], 0.0, 0.05);
  car.drive(0.04, spun);
  EXPECT_GT(car.fused[Source::yaw_rate], 0);
  EXPECT_NEAR(car.state.mean[at::yaw_rate], 3.0, 0.5);
}

TEST(Take, AGyroThatInsistsOnACarThatStandsHasAnotherBias) {
  Car car;
  car.drive(3.0, straight_at(0.0));
  ASSERT_TRUE(car.state.rest.standing);
  car.drive(0.5, with(straight_at(0.0), Source::yaw_rate, 0.06));
  EXPECT_GT(car.gated[Source::yaw_rate], 5);
  EXPECT_TRUE(car.state.rest.standing);
  EXPECT_NEAR(car.state.mean[at::gyro_bias], 0.06, 0.003);
  EXPECT_EQ(car.state.mean[at::yaw_rate], 0.0);
}

TEST(Take, AGyroOfALargeBiasTurnsNoCarThatStands) {
  for (const double bias : {0.15, -0.3}) {
    Car car;
    const Says says = with(straight_at(0.0), Source::yaw_rate, bias);
    car.drive(2.0, says);
    ASSERT_TRUE(car.state.rest.standing);
    EXPECT_NEAR(car.state.mean[at::gyro_bias], bias, 0.003);
    const double yaw = car.state.mean[at::yaw];
    car.drive(20.0, says);
    EXPECT_NEAR(car.state.mean[at::yaw], yaw, 1e-6);
    EXPECT_TRUE(car.gated.empty());
  }
}

TEST(Take, AGyroThatWarmsUpKeepsTheCarStanding) {
  Car car;
  car.drive(2.0, straight_at(0.0));
  const double yaw = car.state.mean[at::yaw];
  for (int i = 0; i <= 600; ++i) {
    car.drive(0.1, with(straight_at(0.0), Source::yaw_rate, 5e-5 * i));
    ASSERT_TRUE(car.state.rest.standing);
  }
  EXPECT_NEAR(car.state.mean[at::gyro_bias], 0.03, 0.01);
  EXPECT_NEAR(car.state.mean[at::yaw], yaw, 1e-6);
}

TEST(Take, LockedWheelsThatSlideAreNoStandstill) {
  Car car;
  car.drive(3.0, straight_at(0.0));
  for (int i = 0; i < 200; ++i) {  // to 3 m/s at 3 m/s²
    car.tick(with(straight_at(0.015 * i), Source::accel_x, 3.0));
  }
  car.drive(1.0, straight_at(3.0));
  const double x = car.state.mean[at::x];
  const double bias = car.state.mean[at::accel_bias_x];
  car.drive(1.5, with(straight_at(0.0), Source::accel_x, -2.0));
  car.drive(1.0, straight_at(0.0));
  EXPECT_TRUE(car.state.rest.standing);
  EXPECT_NEAR(car.state.mean[at::x] - x, 2.25, 0.4);
  EXPECT_NEAR(car.state.mean[at::accel_bias_x], bias, 0.1);
}

TEST(Take, WheelsThatStopWithTheCarAreBelieved) {
  // Against a wall: the accelerometer had no time to feel much of it.
  Car car;
  car.drive(2.0, straight_at(3.0));
  const double x = car.state.mean[at::x];
  car.drive(2.0, straight_at(0.0));
  EXPECT_TRUE(car.state.rest.standing);
  EXPECT_NEAR(car.state.mean[at::x] - x, 0.0, 0.9);
}

TEST(Take, SetsOffAtOnceWithWheelsThatAreBlindToSlowSpeeds) {
  for (const double speed : {0.6, -0.6}) {
    Car car;
    car.drive(2.0, straight_at(0.0));
    ASSERT_TRUE(car.state.rest.standing);
    car.drive(0.02, straight_at(speed));
    EXPECT_NEAR(car.state.mean[at::v_x], speed, 0.02);
    car.drive(0.1, straight_at(speed));
    EXPECT_TRUE(car.gated.empty());
  }
}

TEST(Take, OneWheelThatTurnsMovesNoCarThatStands) {
  for (const double speed : {0.3, 1.0, 3.0}) {
    Car car;
    const Says stuck = with(straight_at(0.0), Source::wheel_rear_right, speed);
    car.drive(5.0, stuck);
    EXPECT_TRUE(car.state.rest.standing) << speed;
    EXPECT_NEAR(car.state.mean[at::x], 0.0, 0.02) << speed;
    // Nor does it keep one standing, or lead one that drives.
    car.drive(4.0, with(straight_at(1.0), Source::wheel_rear_right, speed));
    EXPECT_NEAR(car.state.mean[at::v_x], 1.0, 0.02) << speed;
    EXPECT_NEAR(car.state.mean[at::x], 4.0, 0.1) << speed;
  }
}

TEST(Take, DrivenWheelsThatSpinAtTheStartDoNotSetItsSpeed) {
  Car car;
  car.drive(3.0, straight_at(0.0));
  const double x = car.state.mean[at::x];
  Says spinning = with(straight_at(0.0), Source::wheel_rear_left, 3.0);
  spinning.signals[Source::wheel_rear_right] = 3.0;
  car.drive(0.5, spinning);
  for (int i = 0; i < 200; ++i) {  // off at 1 m/s²
    Says rolling = with(spinning, Source::wheel_front_left, 0.005 * i);
    rolling.signals[Source::wheel_front_right] = 0.005 * i;
    car.tick(with(rolling, Source::accel_x, 1.0));
  }
  EXPECT_NEAR(car.state.mean[at::v_x], 1.0, 0.1);
  EXPECT_NEAR(car.state.mean[at::x] - x, 0.5, 0.1);
}

TEST(Take, AWheelOfOnesOwnSetsOffWithItsSecondTurningSample) {
  Car car;
  const Says still{{{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}, {Source::motor, 0.0}}};
  car.drive(3.0, still);
  ASSERT_TRUE(car.state.rest.standing);
  EXPECT_EQ(car.say(Source::motor, 2.0).verdict, Verdict::gated);
  car.drive(0.1, still);
  EXPECT_TRUE(car.state.rest.standing);
  EXPECT_NEAR(car.state.mean[at::x], 0.0, 1e-3);
  car.drive(0.1, with(still, Source::motor, 0.5));
  EXPECT_NEAR(car.state.mean[at::v_x], 0.5, 0.02);
}

TEST(Take, ADeadWheelIsOutvotedAfterADropOut) {
  for (const double silence : {0.1, 0.26, 0.3, 1.5}) {
    Car car;
    car.drive(3.0, straight_at(2.0));
    const Says dead = with(straight_at(2.0), Source::wheel_front_left, 0.0);
    car.drive(2.0, dead);
    car.drive(silence, {{{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}}});
    car.drive(5.0, dead);
    EXPECT_NEAR(car.state.mean[at::v_x], 2.0, 0.02) << silence;
    EXPECT_NEAR(car.state.mean[at::x], 2.0 * (10.0 + silence), 0.3) << silence;
    EXPECT_EQ(car.fused[Source::wheel_front_left], 0) << silence;
  }
}

TEST(Take, ABiasThatIsKnownIsNotGivenUpForACreepThatTheWheelsDoNotSee) {
  Car car;
  car.drive(10.0, straight_at(0.0));
  ASSERT_LT(std::sqrt(car.state.covariance(at::gyro_bias, at::gyro_bias)), 0.005);
  car.drive(1.5, with(straight_at(0.0), Source::yaw_rate, 0.09));
  EXPECT_FALSE(car.state.rest.standing);
  EXPECT_NEAR(car.state.mean[at::gyro_bias], 0.0, 0.005);
  EXPECT_GT(car.state.mean[at::yaw], 0.05);
}

TEST(Take, AnHonestGyroKeepsTheCarStanding) {
  std::mt19937 random(3);
  for (const double sigma : {0.005, 0.03, 0.1}) {
    Car car;
    std::normal_distribution<double> noise(0.0, sigma);
    int departed = 0;
    for (int tick = 0; tick < 12'000; ++tick) {
      car.tick(without(straight_at(0.0), Source::yaw_rate));
      (void)take(car.context, car.state,
                 {.time_ns = car.state.time_ns,
                  .source = Source::yaw_rate,
                  .value = {noise(random)},
                  .sigma = {sigma}});
      departed += tick > 400 && !car.state.rest.standing ? 1 : 0;
    }
    EXPECT_EQ(departed, 0) << sigma;
  }
}

TEST(Take, NothingIsLearntOfTheMotionBeforeItIsFollowed) {
  // On a circle, with the IMU heard long before the wheels.
  Car car;
  const Says imu{{{Source::yaw_rate, 1.0},
                  {Source::accel_x, 0.0},
                  {Source::accel_y, 1.5},
                  {Source::steering, 0.175}}};
  car.drive(2.0, imu);
  EXPECT_EQ(car.state.mean[at::accel_bias_y], 0.0);
  Says wheels = with(imu, Source::motor, 1.5);
  car.drive(1.0, wheels);
  EXPECT_TRUE(car.gated.empty());
  EXPECT_NEAR(car.state.mean[at::yaw], 1.0, 0.05);
  EXPECT_NEAR(car.state.mean[at::accel_bias_y], 0.0, 0.3);
}

TEST(Take, NoCarIsKnownToStandWithoutItsWheels) {
  Car car;
  car.drive(3.0, straight_at(0.0));
  ASSERT_TRUE(car.state.rest.standing);
  car.drive(4.0, {{{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}}});
  EXPECT_FALSE(car.state.rest.standing);
  EXPECT_GT(std::sqrt(car.state.covariance(at::v_x, at::v_x)), 0.05);
}

TEST(Take, ADirectionThatComesLateTurnsTheSpeedAtOnce) {
  Car car;
  car.say(Source::direction, 1.0);
  car.drive(1.0, straight_at(0.3));
  car.say(Source::direction, -1.0);
  car.drive(0.03, straight_at(0.3));
  EXPECT_NEAR(car.state.mean[at::v_x], -0.3, 0.03);
}

TEST(Take, AnAccelerometerIsNotSilentForDriving) {
  Car car;
  car.drive(2.0, straight_at(0.0));
  car.drive(5.0, straight_at(1.0));
  EXPECT_EQ(car.say(Source::accel_x, 100.0).verdict, Verdict::gated);
  car.drive(0.1, straight_at(1.0));
  EXPECT_LE(car.gated[Source::accel_x], 1);
}

TEST(Take, OneWildSpeedMovesNoCarThatStands) {
  Car car;
  car.drive(2.0, straight_at(0.0));
  const double x = car.state.mean[at::x];
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(car.say(Source::wheel_rear_left, 80.0).verdict, Verdict::gated);
    car.drive(0.1, straight_at(0.0));
    EXPECT_TRUE(car.state.rest.standing);
  }
  EXPECT_NEAR(car.state.mean[at::x], x, 1e-6);
}

TEST(Take, ASpeedThatIsPolledOnceASecondIsFollowed) {
  Car car;
  for (int second = 0; second < 30; ++second) {
    car.drive(1.0, {{{Source::yaw_rate, 0.0}}});
    car.say(Source::motor, second < 10 ? 3.0 * second : 30.0);
  }
  EXPECT_NEAR(car.state.mean[at::v_x], 30.0, 0.1);
  EXPECT_NEAR(car.state.mean[at::x], 20.0 * 30.0 + 0.5 * 10.0 * 30.0, 60.0);
}

TEST(Take, TelegramsThatContradictEachOtherNeverInsist) {
  // What is left of a bus on which only chance telegrams pass for the wheels'.
  const Says silent{{{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}}};
  int astray = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Car car;
    car.drive(2.0, straight_at(1.0));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-100.0, 100.0);
    for (int i = 0; i < 50; ++i) {
      car.drive(0.3, silent);
      car.say(Source::wheel_rear_left, any(random));
    }
    const double way = car.state.mean[at::x] - 17.0;
    astray += std::abs(way) > 3.0 * std::sqrt(car.state.covariance(at::x, at::x)) ? 1 : 0;
  }
  EXPECT_LE(astray, 1);
}

TEST(Take, ASourceThatComesBackNeedsOthersThatSayTheSame) {
  Car car;
  car.drive(2.0, straight_at(1.0));
  const Says silent{{{Source::accel_x, 0.0}}};
  car.drive(3.0, silent);
  EXPECT_EQ(car.say(Source::yaw_rate, 9.0).verdict, Verdict::gated);
  EXPECT_EQ(car.say(Source::wheel_rear, 60.0).verdict, Verdict::gated);
  for (const Verdict verdict : {Verdict::gated, Verdict::gated, Verdict::fused}) {
    car.drive(0.01, silent);
    EXPECT_EQ(car.say(Source::yaw_rate, 0.1).verdict, verdict);
    EXPECT_EQ(car.say(Source::wheel_rear, 1.2).verdict, verdict);
  }
}

TEST(Take, OneWildAccelerationIsNoInput) {
  Car car;
  car.drive(2.0, straight_at(1.0));
  for (const Source source : {Source::accel_x, Source::accel_y}) {
    EXPECT_EQ(car.say(source, 150.0).verdict, Verdict::gated);
  }
  EXPECT_EQ(car.state.accel_x.value, 0.0);
  car.drive(0.1, straight_at(1.0));
  EXPECT_LE(car.gated[Source::accel_x], 1);
  EXPECT_EQ(car.gated[Source::accel_y], 0);
  EXPECT_NEAR(car.state.mean[at::v_x], 1.0, 0.01);
}

TEST(Take, AnAccelerometerThatInsistsOnACarThatStandsHasAnotherBias) {
  Car car;
  car.drive(3.0, straight_at(0.0));
  const double force = car.state.covariance(at::front_force, at::front_force);
  car.drive(1.0, with(straight_at(0.0), Source::accel_y, 1.0));
  EXPECT_GT(car.gated[Source::accel_y], 20);
  EXPECT_NEAR(car.state.mean[at::accel_bias_y], 1.0, 0.05);
  EXPECT_EQ(car.state.covariance(at::front_force, at::front_force), force);
}

TEST(Take, AnAccelerometerThatInsistsOnASlopeHasAnotherBiasToo) {
  Car car;
  car.drive(3.0, straight_at(0.0));
  ASSERT_TRUE(car.state.rest.standing);
  car.drive(1.0, with(straight_at(0.0), Source::accel_x, 2.0));
  EXPECT_GT(car.gated[Source::accel_x], 20);
  EXPECT_GT(car.fused[Source::accel_x], 20);
  EXPECT_NEAR(car.state.mean[at::accel_bias_x], 2.0, 0.1);
}

TEST(Take, OneSpikeOfTheGyroIsLeftOut) {
  Car car;
  car.drive(2.0, straight_at(1.0));
  for (int i = 0; i < 20; ++i) {
    car.tick(with(straight_at(1.0), Source::yaw_rate, 8.0));
    EXPECT_NEAR(car.state.mean[at::yaw_rate], 0.0, 0.02);
    car.drive(0.1, straight_at(1.0));
    EXPECT_EQ(car.gated[Source::yaw_rate], 0);
  }
  EXPECT_NEAR(car.state.mean[at::yaw], 0.0, 0.005);
}

TEST(Take, WithoutAGyroTheWheelsTellTheTurn) {
  Car car;
  const double yaw_rate = 1.0;
  const Vehicle vehicle;
  const double half_track = 0.5 * vehicle.track_width;
  const Says says{{{Source::wheel_rear_left, 1.5 - half_track * yaw_rate},
                   {Source::wheel_rear_right, 1.5 + half_track * yaw_rate}}};
  car.drive(4.0, says);
  EXPECT_NEAR(car.state.mean[at::yaw_rate], yaw_rate, 0.1);
  EXPECT_NEAR(car.state.mean[at::v_x], 1.5, 0.02);
}

TEST(Take, UnsignedWheelsTakeTheSignOfTheDirection) {
  Car car;
  car.say(Source::direction, -1.0);
  car.drive(3.0, straight_at(1.0));
  EXPECT_NEAR(car.state.mean[at::v_x], -1.0, 0.02);
  EXPECT_NEAR(car.state.mean[at::x], -3.0, 0.05);
  EXPECT_TRUE(car.gated.empty());
}

TEST(Take, ReversesThroughStandstill) {
  Car car;
  car.say(Source::direction, 1.0);
  car.drive(1.0, straight_at(0.5));
  const double turn_around = car.state.mean[at::x];
  for (int i = 0; i < 100; ++i) {  // at 2 m/s²
    const double v = 0.5 - 0.01 * i;
    car.say(Source::direction, v < 0.0 ? -1.0 : 1.0);
    car.tick(with(straight_at(std::abs(v)), Source::accel_x, -2.0));
  }
  car.drive(1.0, straight_at(0.5));
  EXPECT_NEAR(car.state.mean[at::v_x], -0.5, 0.02);
  EXPECT_NEAR(car.state.mean[at::x] - turn_around, -0.5, 0.05);
  EXPECT_NEAR(car.state.mean[at::yaw], 0.0, 0.01);
}

TEST(Take, AnUnknownOrForwardDirectionLeavesSignsAlone) {
  for (const double direction : {0.0, 1.0}) {
    Car car;
    car.say(Source::direction, direction);
    car.drive(1.0, straight_at(-0.7));
    EXPECT_NEAR(car.state.mean[at::v_x], -0.7, 0.02);
  }
}

TEST(Take, InputsAreForgottenWithAge) {
  State state;
  state.time_ns = 1'000 * millisecond;
  EXPECT_FALSE(input_of(state).has_steering);
  EXPECT_FALSE(input_of(state).has_accel_x);
  state.steering = {true, state.time_ns, 0.2};
  state.accel_x = {true, state.time_ns, 1.5};
  EXPECT_TRUE(input_of(state).has_steering);
  EXPECT_EQ(input_of(state).steering, 0.2);
  EXPECT_TRUE(input_of(state).has_accel_x);
  EXPECT_EQ(input_of(state).accel_x, 1.5);
  state.time_ns += 5'000 * millisecond;
  EXPECT_FALSE(input_of(state).has_steering);
  EXPECT_FALSE(input_of(state).has_accel_x);
}

TEST(Take, WhatIsNoSourceIsOff) {
  Car car;
  EXPECT_EQ(car.say(Source::yaw_rate, 0.0).verdict, Verdict::fused);
  const Sample odd{.time_ns = car.state.time_ns, .source = Source::count};
  EXPECT_EQ(take(car.context, car.state, odd).verdict, Verdict::source_off);
}

TEST(Advance, GoesInStepsOfAtMostAPeriod) {
  Car car;
  car.drive(1.0, straight_at(1.0));
  car.state.mean[at::yaw_rate] = 0.5;
  State whole = car.state;
  State stepped = car.state;
  advance(car.context, whole, whole.time_ns + 10 * period_ns);
  for (int i = 0; i < 10; ++i) {
    advance(car.context, stepped, stepped.time_ns + period_ns);
  }
  EXPECT_EQ(whole.time_ns, stepped.time_ns);
  EXPECT_LT((whole.mean - stepped.mean).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((whole.covariance - stepped.covariance).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Advance, NeverGoesBack) {
  Car car;
  car.drive(1.0, straight_at(1.0));
  const State before = car.state;
  advance(car.context, car.state, before.time_ns - period_ns);
  advance(car.context, car.state, before.time_ns);
  EXPECT_EQ(car.state.time_ns, before.time_ns);
  EXPECT_EQ(car.state.mean, before.mean);
  EXPECT_EQ(car.state.covariance, before.covariance);
}

TEST(Advance, ACarThatStandsOnlyForgetsItsCalibrations) {
  Car car;
  car.drive(1.0, straight_at(0.0));
  ASSERT_TRUE(car.state.rest.standing);
  const State before = car.state;
  advance(car.context, car.state, before.time_ns + 400 * period_ns);
  EXPECT_EQ(car.state.mean, before.mean);
  const Matrix grown = car.state.covariance - before.covariance;
  EXPECT_EQ((grown.topLeftCorner<8, 8>().cwiseAbs().maxCoeff()), 0.0);
  EXPECT_GT(grown(at::gyro_bias, at::gyro_bias), 0.0);
  EXPECT_GT(grown(at::wheel_scale, at::wheel_scale), 0.0);
}

}  // namespace
}  // namespace odomd::estimator::full::take_test
