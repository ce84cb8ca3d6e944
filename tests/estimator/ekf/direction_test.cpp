// The sign of unsigned wheel speeds, from the direction's samples and without them.
#include "tests/estimator/signalled_car.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing::direction_test {
namespace {

TEST(Direction, ReversesThroughStandstill) {
  Car car;
  car.push(Source::direction, 1.0);
  car.drive(1.0, straight_at(0.5));
  const double turn_around = car.x();
  for (int i = 0; i < 100; ++i) {  // at 2 m/s²
    const double v = 0.5 - 0.01 * i;
    car.push(Source::direction, v < 0.0 ? -1.0 : 1.0);
    car.tick(with(straight_at(std::abs(v)), Source::accel_x, -2.0));
  }
  car.drive(1.0, straight_at(0.5));
  EXPECT_NEAR(car.v_x(), -0.5, 0.02);
  EXPECT_NEAR(car.x() - turn_around, -0.5, 0.05);
  EXPECT_NEAR(car.yaw(), 0.0, 0.01);
}

TEST(Direction, ADirectionThatComesLateLeavesThePlaceUncertain) {
  Car car;
  car.push(Source::direction, 1.0);
  car.drive(3.0, straight_at(0.0));
  const double before = car.state.covariance(at::x, at::x);
  const double x = car.x();
  for (int i = 0; i < 80; ++i) {  // reverses at 1 m/s²
    car.tick(with(straight_at(0.005 * i), Source::accel_x, -1.0));
  }
  car.push(Source::direction, -1.0);
  const double off = car.x() - (x - 0.5 * 0.4 * 0.4);
  EXPECT_GT(off, 0.05);
  EXPECT_LT(off, 4.0 * std::sqrt(car.state.covariance(at::x, at::x) - before));
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
  for (int i = 0; i < 100; ++i) {  // at 2 m/s²
    car.tick(with(straight_at(0.01 * i), Source::accel_x, 2.0));
  }
  car.drive(3.0, straight_at(1.0));
  EXPECT_NEAR(car.v_x(), 1.0, 0.05);
  EXPECT_NEAR(car.x() - x, 3.25, 0.1);
}

TEST(Direction, NoiseAboutZeroDoesNotShowThatSpeedsHaveASign) {
  const auto reversing = [](double speed) {
    SensorValues values = bend_at(-speed, 0.5 * speed);
    for (auto& [source, value] : values.signals)
      if (is_wheel(source)) value = std::abs(value);
    return values;
  };
  Car car;
  for (int i = 0; i < 400; ++i) car.tick(straight_at(i % 20 < 10 ? 0.0 : -0.001));
  for (int i = 0; i < 100; ++i)  // at 2 m/s²
    car.tick(with(reversing(0.01 * i), Source::accel_x, -2.0));
  car.drive(3.0, reversing(1.0));
  EXPECT_NEAR(car.v_x(), -1.0, 0.05);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::direction_test
