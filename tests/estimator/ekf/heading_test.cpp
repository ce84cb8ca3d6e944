// The yaw from the gyro: its integral, bias, scale and noise. The sign of unsigned wheel speeds,
// from the samples of the direction and without them.
#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::heading_test {
namespace {

TEST(Heading, AConsistentGyroIsAcceptedAfterItsTimeout) {
  // A bump spins the car on the spot, without an effect on wheels and steering.
  Car car = car_after(2.0, straight_at(1.0));
  const SensorValues spun = without(with(straight_at(1.0), Source::yaw_rate, 3.0), Source::accel_y);
  car.drive(0.005, spun);
  EXPECT_EQ(car.fused[Source::yaw_rate], 0);
  EXPECT_NEAR(car.yaw_rate(), 0.0, 0.05);
  car.drive(0.04, spun);
  EXPECT_GT(car.fused[Source::yaw_rate], 0);
  EXPECT_NEAR(car.yaw_rate(), 3.0, 0.5);
}

/// The gyro sends ten readings a second, all other sources send at every tick.
void drive_with_slow_gyro(Car& car, double seconds, const SensorValues& values, double yaw_rate) {
  for (int i = 0; i < std::lround(10.0 * seconds); ++i) {
    car.drive(0.1, without(values, Source::yaw_rate));
    car.push(Source::yaw_rate, yaw_rate);
  }
}

TEST(Heading, TheHeadingIsTheGyrosIntegralWhateverTheSteeringSays) {
  // The steering is trusted after a long straight; in the bend that follows, it is wrong.
  Car car;
  drive_with_slow_gyro(car, 20.0, straight_at(2.0), 0.0);
  const SensorValues bend = bend_at(2.0, 0.5);
  car.drive(1.0, bend);
  const double begin = car.yaw();
  drive_with_slow_gyro(car, 10.0, with(bend, Source::steering, 0.1), 0.5);
  EXPECT_NEAR(car.yaw() - begin, 5.0, 0.005);
}

TEST(Heading, BiasAndScaleOfTheGyroActOnTheHeadingAllTheTime) {
  // Also at very low speed, where tyres would straighten the car between two gyro samples.
  for (const double speed : {0.1, 2.0}) {
    Car car;
    car.state.slow.mean[slow::gyro_bias] = 0.02;
    car.state.slow.mean[slow::gyro_scale] = 0.1;
    car.drive(5.0, with(straight_at(speed), Source::yaw_rate, 0.02));
    const SensorValues bend = without(bend_at(speed, 0.5), Source::steering);
    constexpr double reads = 1.1 * 0.5 + 0.02;
    car.drive(1.0, with(bend, Source::yaw_rate, reads));
    const double yaw = car.yaw();
    const SlowVector by = car.state.slow.sensitivity.row(at::yaw);
    drive_with_slow_gyro(car, 20.0, bend, reads);
    EXPECT_NEAR(car.yaw() - yaw, 10.0, 1e-3) << speed;
    const SlowVector more = car.state.slow.sensitivity.row(at::yaw).transpose() - by;
    EXPECT_NEAR(more[slow::gyro_bias], -20.0 / 1.1, 1e-3) << speed;
    EXPECT_NEAR(more[slow::gyro_scale], -10.0 / 1.1, 1e-3) << speed;
    EXPECT_NEAR(more[slow::stiffness_scale], 0.0, 1e-3) << speed;
  }
}

TEST(Heading, TheHeadingIsNoMorePreciseThanTheGyrosNoise) {
  for (const double speed : {0.1, 0.3, 2.0}) {
    Car car;
    car.context.model.tuning.noise_range = 1.0;
    drive_with_slow_gyro(car, 20.0, straight_at(speed), 0.0);
    const double before = car.state.variance(at::yaw);
    drive_with_slow_gyro(car, 20.0, straight_at(speed), 0.0);
    // The noise of two hundred intervals of 0.1 s.
    const double noise = 0.1 * Car::sigmas[index_of(Source::yaw_rate)];
    EXPECT_GE(car.state.variance(at::yaw) - before, 0.99 * 200 * noise * noise) << speed;
  }
}

TEST(Heading, AGyroWithoutASampleHasNoIntegral) {
  Car car;
  car.state.time_ns = 0;  // the time at which a log may begin
  car.drive(0.1, without(straight_at(2.0), Source::yaw_rate));
  ASSERT_TRUE(car.state.moving);
  for (int i = 0; i < 3; ++i) {
    car.push(Source::yaw_rate, 0.5);
    EXPECT_GT(car.state.slow.sensitivity(at::yaw, slow::gyro_bias), -0.08);
    car.drive(0.005, without(straight_at(2.0), Source::yaw_rate));
  }
}

TEST(Heading, ASpinByTheGyroAloneIsAFault) {
  // Wheels, steering and lateral acceleration contradict the gyro.
  Car car = car_after(2.0, straight_at(1.0));
  const double yaw = car.yaw();
  car.drive(2.0, [](double t) {
    return with(straight_at(1.0), Source::yaw_rate, std::min(100.0 * t, 4.0));
  });
  EXPECT_FALSE(car.state.integrity.trusted(Source::yaw_rate));
  EXPECT_NEAR(car.yaw(), yaw, 0.5);
  EXPECT_TRUE(car.state.doubtful);
}

TEST(Direction, ReversesThroughStandstill) {
  Car car;
  car.push(Source::direction, 1.0);
  car.drive(1.0, straight_at(0.5));
  const double turn_around = car.x();
  for (int i = 0; i < 100; ++i) {  // at 2 m/s²
    const double v = 0.5 - 0.01 * i;
    car.push(Source::direction, v < 0.0 ? -1.0 : 1.0);
    car.tick(straight_at(std::abs(v), -2.0));
  }
  car.drive(1.0, straight_at(0.5));
  EXPECT_NEAR(car.v_x(), -0.5, 0.02);
  EXPECT_NEAR(car.x() - turn_around, -0.5, 0.05);
  EXPECT_NEAR(car.yaw(), 0.0, 0.01);
}

TEST(Direction, ALateDirectionLeavesThePositionUncertain) {
  Car car;
  car.push(Source::direction, 1.0);
  car.drive(3.0, straight_at(0.0));
  const double before = car.state.variance(at::x);
  const double x = car.x();
  car.drive(0.4, [](double t) { return straight_at(t, -1.0); });
  car.push(Source::direction, -1.0);
  const double off = car.x() - (x - 0.5 * 0.4 * 0.4);
  EXPECT_GT(off, 0.05);
  EXPECT_LT(off, 4.0 * std::sqrt(car.state.variance(at::x) - before));
}

TEST(Direction, ALostDirectionIsUnknownAfterAHalt) {
  Car car;
  for (int i = 0; i < 400; ++i) {
    car.push(Source::direction, -1.0);
    car.tick(straight_at(1.0));
  }
  ASSERT_LT(car.v_x(), -0.9);
  car.drive(1.0, straight_at(1.0));
  EXPECT_LT(car.v_x(), -0.9);  // it cannot have turned around without a halt
  car.drive(2.0, straight_at(0.0));
  const double x = car.x();
  car.drive(0.5, [](double t) { return straight_at(2.0 * t, 2.0); });
  car.drive(3.0, straight_at(1.0));
  EXPECT_NEAR(car.v_x(), 1.0, 0.05);
  EXPECT_NEAR(car.x() - x, 3.25, 0.1);
}

TEST(Direction, NoiseAboutZeroDoesNotShowThatSpeedsHaveASign) {
  const auto reversing = [](double speed) {
    SensorValues values = bend_at(-speed, 0.5 * speed);
    for (auto& [source, value] : values)
      if (is_wheel(source)) value = std::abs(value);
    return values;
  };
  Car car;
  for (int i = 0; i < 400; ++i) car.tick(straight_at(i % 20 < 10 ? 0.0 : -0.001));
  car.drive(0.5, [&](double t) { return with(reversing(2.0 * t), Source::accel_x, -2.0); });
  car.drive(3.0, reversing(1.0));
  EXPECT_NEAR(car.v_x(), -1.0, 0.05);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::heading_test
