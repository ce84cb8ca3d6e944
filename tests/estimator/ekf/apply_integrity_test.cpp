// Effects of the integrity verdict on the filter: resets to the consensus, forced samples, doubtful
// poses.
#include "estimator/ekf/update.hpp"
#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::apply_integrity_test {
namespace {

TEST(ApplyIntegrity, ADriveWithoutFaultsIsNotCorrectedNorDoubtful) {
  Car car = car_after(3.0, straight_at(1.5));
  car.drive(3.0, bend_at(1.5, 0.8));
  EXPECT_FALSE(car.state.doubtful);
  EXPECT_EQ(car.state.disputed.head<2>().squaredNorm(), 0.0);
  EXPECT_EQ(car.state.of_speed.since_ns, 0);
  EXPECT_EQ(car.state.of_yaw_rate.since_ns, 0);
  EXPECT_NEAR(car.state.integrity.motion().motion[integrity::of::yaw_rate], 0.8, 0.05);
}

TEST(ApplyIntegrity, AWrongSpeedIsResetToTheConsensus) {
  // The filter is certain of a wrong speed.
  Car car = car_after(3.0, straight_at(1.5));
  ASSERT_FALSE(car.state.doubtful);
  const double before = car.state.variance(at::x);
  car.state.mean[at::v_x] = 6.0;
  forget(car.state, at::v_x, 1e-3);
  car.drive(0.4, straight_at(1.5));
  EXPECT_NEAR(car.v_x(), 1.5, 0.1);
  EXPECT_GT(car.state.variance(at::x), before);
}

TEST(ApplyIntegrity, AWrongYawRateIsResetToTheConsensus) {
  // No gyro, because it would correct the yaw rate immediately.
  Car car;
  const SensorValues values = without(bend_at(1.5, 0.8), Source::yaw_rate);
  car.drive(3.0, values);
  ASSERT_FALSE(car.state.doubtful);
  const double before = car.state.variance(at::yaw);
  car.state.mean[at::yaw_rate] = -2.0;
  car.state.mean[at::front_angle] = -0.6;
  forget(car.state, at::yaw_rate, 1e-3);
  forget(car.state, at::front_angle, 1e-3);
  car.drive(0.4, values);
  EXPECT_NEAR(car.yaw_rate(), 0.8, 0.2);
  EXPECT_GT(car.state.variance(at::yaw), before);
}

TEST(ApplyIntegrity, ADistrustedGyroMakesThePoseDoubtful) {
  Car car = car_after(3.0, bend_at(1.5, 0.5));
  ASSERT_FALSE(car.state.doubtful);
  const double yaw = car.yaw();
  car.drive(1.0, with(bend_at(1.5, 0.5), Source::yaw_rate, 2.0));
  EXPECT_FALSE(car.state.integrity.trusted(Source::yaw_rate));
  EXPECT_TRUE(car.state.doubtful);
  EXPECT_NEAR(car.yaw_rate(), 0.5, 0.1);
  EXPECT_NEAR(car.yaw(), yaw + 0.5, 0.5);
  // Without a camera nothing confirms the pose.
  car.drive(10.0, bend_at(1.5, 0.5));
  EXPECT_TRUE(car.state.integrity.trusted(Source::yaw_rate));
  EXPECT_TRUE(car.state.doubtful);
}

TEST(ApplyIntegrity, ALateReversalIsAppliedToTheDrivenDistance) {
  // Without an accelerometer the sign of unsigned wheel speeds is unknown on a straight.
  const auto backwards = [](double speed, double yaw_rate) {
    const SensorValues bend = with(bend_at(speed, -yaw_rate), Source::yaw_rate, yaw_rate);
    return without(bend, Source::accel_x, Source::accel_y);
  };
  Car car = car_after(3.0, backwards(0.0, 0.0));
  ASSERT_TRUE(car.stands());
  for (int i = 0; i < 8; ++i) {
    car.drive(0.245, backwards(1.0, 0.0));
    car.push(Source::wheel_rear_left, -1.0);  // corrupt: wheel speeds are unsigned
    car.tick(backwards(1.0, 0.0));
  }
  ASSERT_FALSE(car.state.integrity.backwards());
  ASSERT_NEAR(car.x(), 2.0, 0.1);
  car.drive(1.0, backwards(1.0, 0.8));
  EXPECT_TRUE(car.state.integrity.backwards());
  EXPECT_TRUE(car.state.doubtful);
  EXPECT_NEAR(car.v_x(), -1.0, 0.05);
  const double off = car.x() - (-2.0 - std::sin(0.8) / 0.8);
  EXPECT_LT(std::abs(off), 0.5);
  EXPECT_LT(off * off, car.state.variance(at::x));
}

TEST(ApplyIntegrity, ASourceThatAgreesWithTheOthersIsForcedAfterItsTimeout) {
  // The filter is certain of a speed that all wheels contradict. Integrity is not checked again, so
  // that it does not correct the filter first.
  Car car = car_after(3.0, straight_at(1.5));
  ASSERT_TRUE(car.state.integrity.agrees(Source::wheel_rear_left));
  car.state.mean[at::v_x] = 3.0;
  forget(car.state, at::v_x, 1e-4);
  forget(car.state, at::accel_x, 1e-4);
  int forced = 0;
  for (int i = 0; i < 60; ++i) {
    advance(car.context, car.state, car.state.time_ns + period_ns);
    car.push(Source::accel_x, i % 2 == 0 ? 1e-9 : -1e-9);
    for (const Source wheel : all_sources) {
      if (!is_single_wheel(wheel) || i % 2 != 0) continue;
      const Judgement judgement = car.push(wheel, 1.5);
      forced += judgement.verdict == Verdict::forced ? 1 : 0;
      EXPECT_FALSE(judgement.verdict == Verdict::forced && judgement.test_ratio <= 1.0);
    }
  }
  EXPECT_GT(forced, 0);
  EXPECT_NEAR(car.v_x(), 1.5, 0.1);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::apply_integrity_test
