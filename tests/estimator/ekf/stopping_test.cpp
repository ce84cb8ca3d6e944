// Stopping, standing and setting off, decided from wheels and gyro together.
#include <random>

#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::stopping_test {
namespace {

TEST(Stopping, APersistentGyroReadingAtStandstillIsANewBias) {
  Car car = car_at_rest();
  const double yaw = car.yaw();
  car.drive(3.0, with(straight_at(0.0), Source::yaw_rate, 0.06));
  EXPECT_LT(car.yaw() - yaw, 0.06 * 2.0);  // until other sources outweigh the step
  EXPECT_TRUE(car.stands());
  EXPECT_NEAR(car.gyro_bias(), 0.06, 0.003);
  EXPECT_EQ(car.state.mean[at::yaw_rate], 0.0);
}

TEST(Stopping, AShortStepOfTheGyroIsNotANewBias) {
  for (const double step : {0.02, 0.06, 0.12}) {
    Car car = car_at_rest(10.0);
    car.drive(0.3, with(straight_at(0.0), Source::yaw_rate, step));
    car.drive(1.0, straight_at(0.0));
    EXPECT_NEAR(car.gyro_bias(), 0.0, 0.1 * step) << step;
  }
}

TEST(Stopping, ALargeGyroBiasDoesNotTurnAStandingCar) {
  for (const double bias : {0.15, -0.3}) {
    Car car;
    const SensorValues values = with(straight_at(0.0), Source::yaw_rate, bias);
    car.drive(2.0, values);
    ASSERT_TRUE(car.stands());
    EXPECT_NEAR(car.gyro_bias(), bias, 0.003);
    const double yaw = car.yaw();
    car.drive(20.0, values);
    EXPECT_NEAR(car.yaw(), yaw, 1e-6);
    EXPECT_TRUE(car.gated.empty());
  }
}

TEST(Stopping, AGyroThatWarmsUpKeepsTheCarStanding) {
  Car car = car_at_rest(2.0);
  const double yaw = car.yaw();
  for (int i = 0; i <= 600; ++i) {
    car.drive(0.1, with(straight_at(0.0), Source::yaw_rate, 5e-5 * i));
    ASSERT_TRUE(car.stands());
  }
  EXPECT_NEAR(car.gyro_bias(), 0.03, 0.01);
  EXPECT_NEAR(car.yaw(), yaw, 1e-6);
}

TEST(Stopping, SlidingLockedWheelsAreNotAStandstill) {
  Car car = car_at_rest();
  car.drive(1.0, [](double t) { return straight_at(3.0 * t, 3.0); });
  car.drive(1.0, straight_at(3.0));
  const double x = car.x();
  const double bias = car.state.mean[at::accel_bias_x];
  car.drive(1.5, straight_at(0.0, -2.0));
  car.drive(1.0, straight_at(0.0));
  EXPECT_TRUE(car.stands());
  EXPECT_NEAR(car.x() - x, 2.25, 0.4);
  EXPECT_NEAR(car.state.mean[at::accel_bias_x], bias, 0.1);
}

TEST(Stopping, WheelsThatStopWithTheCarAreAccepted) {
  // The car hits a wall, too suddenly for the accelerometer. Dead wheels would look the same, so
  // the standstill takes a while, and the pose is doubtful.
  Car car = car_after(2.0, straight_at(3.0));
  const double x = car.x();
  car.drive(4.0, straight_at(0.0));
  EXPECT_TRUE(car.stands());
  EXPECT_LT(car.x() - x, 8.0);
  EXPECT_TRUE(car.state.doubtful);
}

TEST(Stopping, SetsOffAtOnceWithWheelsThatAreBlindToSlowSpeeds) {
  for (const double speed : {0.6, -0.6}) {
    Car car = car_at_rest(2.0);
    car.drive(0.02, straight_at(speed));
    EXPECT_NEAR(car.v_x(), speed, 0.02);
    car.drive(0.1, straight_at(speed));
    EXPECT_TRUE(car.gated.empty());
  }
}

TEST(Stopping, WheelsThatAreBlindToACreepDoNotHoldACarWhoseMotorTurns) {
  Car car = car_after(3.0, with(straight_at(0.0), Source::motor, 0.0));
  ASSERT_TRUE(car.stands());
  const double x = car.x();
  car.drive(10.0, with(straight_at(0.0), Source::motor, 0.05));
  EXPECT_FALSE(car.stands());
  EXPECT_NEAR(car.x() - x, 0.5, 0.05);
}

TEST(Stopping, OneTurningWheelDoesNotMoveAStandingCar) {
  for (const double speed : {0.3, 1.0, 3.0}) {
    Car car;
    const SensorValues stuck = with(straight_at(0.0), Source::wheel_rear_right, speed);
    car.drive(5.0, stuck);
    EXPECT_TRUE(car.stands()) << speed;
    EXPECT_NEAR(car.x(), 0.0, 0.04) << speed;
    // The dead wheel neither keeps the car at a standstill nor moves it.
    car.drive(4.0, with(straight_at(1.0), Source::wheel_rear_right, speed));
    EXPECT_NEAR(car.v_x(), 1.0, 0.02) << speed;
    EXPECT_NEAR(car.x(), 4.0, 0.1) << speed;
  }
}

TEST(Stopping, SpinningDrivenWheelsNeitherMoveTheCarNorSetItsSpeed) {
  const auto spinning = [](double speed, double accel) {
    return with(straight_at(speed, accel),
                {{Source::wheel_rear_left, 3.0}, {Source::wheel_rear_right, 3.0}});
  };
  for (const double spin_s : {0.5, 3.0}) {
    Car car = car_at_rest();
    const double x = car.x();
    car.drive(spin_s, spinning(0.0, 0.0));
    EXPECT_TRUE(car.stands()) << spin_s;
    EXPECT_NEAR(car.x(), x, 1e-6) << spin_s;
    car.drive(1.0, [&](double t) { return spinning(t, 1.0); });
    EXPECT_NEAR(car.v_x(), 1.0, 0.1) << spin_s;
    EXPECT_NEAR(car.x() - x, 0.5, 0.1) << spin_s;
  }
}

TEST(Stopping, ASingleWheelSetsOffWithItsSecondTurningSample) {
  Car car;
  const SensorValues still{{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}, {Source::motor, 0.0}};
  car.drive(3.0, still);
  ASSERT_TRUE(car.stands());
  EXPECT_EQ(car.push(Source::motor, 2.0).verdict, Verdict::gated);
  car.drive(0.1, still);
  EXPECT_TRUE(car.stands());
  EXPECT_NEAR(car.x(), 0.0, 1e-3);
  car.drive(0.1, with(still, Source::motor, 0.5));
  EXPECT_NEAR(car.v_x(), 0.5, 0.02);
}

TEST(Stopping, AKnownBiasIsKeptDuringACreepThatTheWheelsDoNotSee) {
  Car car = car_at_rest(10.0);
  ASSERT_LT(car.state.sigma(slow::gyro_bias), 0.005);
  car.drive(1.5, with(straight_at(0.0), Source::yaw_rate, 0.09));
  EXPECT_FALSE(car.stands());
  EXPECT_NEAR(car.gyro_bias(), 0.0, 0.005);
  EXPECT_GT(car.yaw(), 0.05);
}

TEST(Stopping, AGyroWithoutFaultKeepsTheCarStanding) {
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
      departed += tick > 400 && !car.stands() ? 1 : 0;
    }
    EXPECT_EQ(departed, 0) << sigma;
  }
}

TEST(Stopping, WithoutWheelsNoStandstillIsKept) {
  Car car = car_at_rest();
  car.drive(4.0, {{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}});
  EXPECT_FALSE(car.stands());
  EXPECT_GT(std::sqrt(car.state.variance(at::v_x)), 0.05);
}

TEST(Stopping, OneWildSpeedDoesNotMoveAStandingCar) {
  Car car = car_at_rest(2.0);
  const double x = car.x();
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(car.push(Source::wheel_rear_left, 80.0).verdict, Verdict::gated);
    car.drive(0.1, straight_at(0.0));
    EXPECT_TRUE(car.stands());
  }
  EXPECT_NEAR(car.x(), x, 1e-6);
}

TEST(Stopping, APersistentAccelerationAtStandstillIsANewBiasOnASlopeToo) {
  Car side = car_at_rest();
  const double front = side.state.variance(at::front_angle);
  side.drive(1.0, with(straight_at(0.0), Source::accel_y, 1.0));
  EXPECT_GT(side.gated[Source::accel_y], 20);
  EXPECT_NEAR(side.state.mean[at::accel_bias_y], 1.0, 0.05);
  EXPECT_EQ(side.state.variance(at::front_angle), front);
  Car slope = car_at_rest();
  slope.drive(2.0, straight_at(0.0, 2.0));
  EXPECT_NEAR(slope.state.mean[at::accel_bias_x], 2.0, 0.1);
}

TEST(Stopping, AWheelThatEntersItsDeadBandHasNotFailed) {
  Car car = car_at_rest(2.0);
  car.drive(2.0, with(straight_at(0.3), Source::motor, 0.3));
  for (int i = 0; i < 1000; ++i) {
    car.tick(with(straight_at(0.0), Source::motor, 0.06));
    ASSERT_EQ(car.state.integrity.flag(Source::wheel_rear_left), SourceFlag::ok) << i;
  }
  EXPECT_FALSE(car.state.doubtful);
  EXPECT_NEAR(car.v_x(), 0.06, 0.01);
}

TEST(Stopping, SettingOffBelowTheWheelsResolutionCorrectsNoBiasAndWidensThePlace) {
  // The car sets off at 1 m/s², with wheels that read zero below 0.7 m/s.
  Car car = car_at_rest();
  car.state.standstill.dead_band.fill(0.8);
  const double x = car.x();
  const double bias = car.state.mean[at::accel_bias_x];
  const double before = car.state.variance(at::x);
  car.drive(0.7, straight_at(0.0, 1.0));
  EXPECT_NEAR(car.state.mean[at::accel_bias_x], bias, 0.02);
  car.drive(0.02, straight_at(0.7));
  ASSERT_FALSE(car.stands());
  // The accelerometer has measured the distance.
  EXPECT_LT(std::abs(car.x() - x - 0.5 * 0.7 * 0.7),
            3.0 * std::sqrt(car.state.variance(at::x) - before));
}

TEST(Stopping, OneDeadWheelOfTwoDoesNotHoldTheCar) {
  // On a straight, and on a circle, where the gyro ends the standstill.
  for (const double turn_per_metre : {0.0, 1.0}) {
    const auto driven_at = [&](double speed, double accel) {
      const SensorValues bend = with(bend_at(speed, turn_per_metre * speed),
                                     {{Source::wheel_rear_right, 0.0}, {Source::accel_x, accel}});
      return without(bend, Source::wheel_front_left, Source::wheel_front_right);
    };
    Car car = car_after(3.0, driven_at(0.0, 0.0));
    ASSERT_TRUE(car.stands());
    car.drive(0.5, [&](double t) { return driven_at(2.0 * t, 2.0); });
    ASSERT_FALSE(car.stands());
    car.drive(2.0, driven_at(1.0, 0.0));
    EXPECT_NEAR(car.v_x(), 1.0, turn_per_metre == 0.0 ? 0.02 : 0.05);
    if (turn_per_metre == 0.0) {
      EXPECT_NEAR(car.x(), 2.25, 0.25);
    }
  }
}

TEST(Stopping, SettingOffDuringAGapMakesThePositionUncertain) {
  // No samples arrive while the car sets off; the first one afterwards is the gyro's.
  Car car = car_at_rest();
  const double before = car.state.variance(at::x);
  advance(car.context, car.state, car.state.time_ns + 400 * millisecond);
  for (int i = 0; i < 3; ++i) {
    advance(car.context, car.state, car.state.time_ns + period_ns);
    car.push(Source::yaw_rate, 0.8);
  }
  ASSERT_FALSE(car.stands());
  car.drive(0.2, with(straight_at(1.0), Source::yaw_rate, 0.8));
  EXPECT_NEAR(car.v_x(), 1.0, 0.1);
  EXPECT_GT(car.state.variance(at::x) - before, 0.08 * 0.08);
}

TEST(Stopping, SilentWheelsDoNotHideADeparture) {
  // The wheels fall silent before the car sets off, and are back once it drives.
  constexpr double accel = 1.5;
  for (const double silent_s : {0.2, 1.0, 1.5}) {
    Car car = car_at_rest();
    const double x = car.x();
    const auto only_inertial = [&](double a) {
      advance(car.context, car.state, car.state.time_ns + period_ns);
      car.push(Source::yaw_rate, 0.0);
      car.push(Source::accel_x, a);
    };
    for (int i = 0; i < std::lround(silent_s / 0.005); ++i) only_inertial(0.0);
    for (int i = 0; i < 200; ++i) only_inertial(accel);
    const double off = car.x() - x - 0.5 * accel;
    EXPECT_FALSE(car.stands()) << silent_s;
    EXPECT_LT(std::abs(off), 3.0 * std::sqrt(car.state.variance(at::x))) << silent_s;
    car.drive(0.5, straight_at(accel));
    EXPECT_NEAR(car.v_x(), accel, 0.02) << silent_s;
  }
}

TEST(Stopping, ASilentCarKeepsStandingForAWhile) {
  Car car = car_at_rest();
  advance(car.context, car.state, car.state.time_ns + 1500 * millisecond);
  EXPECT_TRUE(car.stands());
  advance(car.context, car.state, car.state.time_ns + 2000 * millisecond);
  EXPECT_FALSE(car.stands());
  EXPECT_GT(car.state.variance(at::x), 4.0);
}

TEST(Stopping, ATurnThatWasABiasLeavesTheHeadingUncertain) {
  Car car = car_at_rest(5.0);
  const double yaw = car.yaw();
  car.drive(8.0, with(straight_at(0.0), Source::yaw_rate, 0.3));
  EXPECT_TRUE(car.stands());
  EXPECT_NEAR(car.gyro_bias(), 0.3, 0.01);
  EXPECT_LT(std::abs(car.yaw() - yaw), 1.5 * std::sqrt(car.state.variance(at::yaw)));
}

}  // namespace
}  // namespace odomd::estimator::full::testing::stopping_test
