// Dead reckoning with the kinematic model.
#include "tests/estimator/drive.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::testing::kinematic_filter_test {
namespace {

const Vehicle car;

TEST(KinematicFilter, DrivesStraight) {
  Drive drive = start(Model::kinematic);
  const Estimate e = drive.ticks(201, {.speed = 1.5});
  EXPECT_NEAR(e.map.x, 1.5, 1e-12);
  EXPECT_EQ(e.map.y, 0.0);
  EXPECT_EQ(e.map.yaw, 0.0);
}

TEST(KinematicFilter, CentreOfGravityDrivesItsCircle) {
  // The rear axle's radius is l / tan δ; with l_h its hypotenuse is the centre of gravity's radius.
  const double delta = 0.3;
  const double rear_radius = car.wheelbase() / std::tan(delta);
  const double radius = std::hypot(rear_radius, car.rear_axle);
  Drive drive = start(Model::kinematic);
  drive.tick({.speed = 1.0, .steering = delta});
  // The centre lies abeam of the rear axle.
  for (int i = 0; i < 1000; ++i) {
    const Estimate e = drive.tick({.speed = 1.0, .steering = delta});
    EXPECT_NEAR(std::hypot(e.map.x + car.rear_axle, e.map.y - rear_radius), radius, 1e-12);
    EXPECT_NEAR(e.v_y, car.rear_axle * e.yaw_rate, 1e-15);
  }
  EXPECT_NEAR(drive.last.map.yaw, 5.0 / rear_radius, 1e-10);
}

TEST(KinematicFilter, AsPrintedTheCentreOfGravityDrivesTheRearAxlesCircle) {
  const double delta = 0.3;
  const double radius = car.wheelbase() / std::tan(delta);
  Drive drive = start(Model::kinematic_printed);
  for (int i = 0; i < 1000; ++i) {
    const Estimate e = drive.tick({.speed = 1.0, .steering = delta});
    EXPECT_NEAR(std::hypot(e.map.x, e.map.y - radius), radius, 1e-12);
  }
}

TEST(KinematicFilter, ReversesOnTheSameCircle) {
  Drive drive = start(Model::kinematic);
  drive.ticks(1, {.speed = 0.0, .steering = 0.4});
  drive.ticks(200, {.speed = 0.8, .steering = 0.4});
  drive.ticks(200, {.speed = -0.8, .steering = 0.4});
  // The speed is a ramp between ticks, so one more tick completes the two half ticks at start and
  // turn.
  const Estimate e = drive.tick({.speed = 0.0, .steering = 0.4});
  EXPECT_NEAR(e.map.x, 0.0, 1e-12);
  EXPECT_NEAR(e.map.y, 0.0, 1e-12);
  EXPECT_NEAR(e.map.yaw, 0.0, 1e-12);
}

TEST(KinematicFilter, DoesNotListenToTheGyro) {
  Drive drive = start(Model::kinematic);
  EXPECT_EQ(add(drive.filter, Measurement{Source::yaw_rate, 1, 1.0, 0.1}), Verdict::source_off);
  EXPECT_EQ(add(drive.filter, Measurement{Source::accel_y, 1, 1.0, 0.1}), Verdict::source_off);
  EXPECT_EQ(add(drive.filter, Measurement{Source::steering, 1, 0.1, 0.1}), Verdict::fused);
  EXPECT_EQ(add(drive.filter, Measurement{Source::wheel_rear, 1, 1.0, 0.1}), Verdict::fused);
}

TEST(KinematicFilter, SingleRearWheelDrivesTheSameCircleAsTheAxle) {
  const double delta = 0.3;
  const double yaw_rate = std::tan(delta) / car.wheelbase();
  Drive axle = start(Model::kinematic);
  Drive wheel = start(Model::kinematic);
  for (int i = 0; i < 2000; ++i) {
    axle.tick({.speed = 1.0, .steering = delta});
    add(wheel.filter, Measurement{Source::wheel_rear_left, wheel.now_ns + 1,
                                  1.0 - yaw_rate * car.track_width / 2.0, 0.05});
    wheel.tick({.steering = delta});
  }
  // A wheel is corrected with the yaw rate of the previous tick, so it settles within a few ticks.
  EXPECT_NEAR(wheel.last.v_x, 1.0, 1e-12);
  EXPECT_NEAR(wheel.last.map.yaw, axle.last.map.yaw, 0.005);
}

TEST(KinematicFilter, AccelerationFollowsTheAccelerometer) {
  const double delta = 0.2;
  Drive drive = start(Model::kinematic);
  EXPECT_EQ(drive.tick({.speed = 1.0, .steering = delta}).v_x_dot, 0.0);
  const Estimate e = drive.tick({.speed = 1.0, .steering = delta, .accel_x = 0.5});
  EXPECT_DOUBLE_EQ(e.v_x_dot, 0.5 + e.v_y * e.yaw_rate);
  EXPECT_DOUBLE_EQ(e.yaw_accel, e.v_x_dot * std::tan(delta) / car.wheelbase());
  EXPECT_DOUBLE_EQ(e.v_y_dot, car.rear_axle * e.yaw_accel);
  EXPECT_EQ(e.accel_x, 0.5);
  EXPECT_EQ(e.steering, delta);
}

TEST(KinematicFilter, CovarianceComesFromTheSigmasOfTheSamples) {
  const auto yaw_sigma_after = [](double sigma_steering) {
    Drive drive = start(Model::kinematic);
    for (int i = 0; i < 1000; ++i) {
      add(drive.filter, Measurement{Source::steering, drive.now_ns + 1, 0.0, sigma_steering});
      drive.tick({.speed = 2.0});
    }
    return std::sqrt(drive.last.covariance[5] - 0.05 * 0.05);
  };
  // σ_ψ = √n Δt v_x / l σ_δ, straight ahead
  const double expected = std::sqrt(1000.0) * 0.005 * 2.0 / car.wheelbase() * 0.02;
  EXPECT_NEAR(yaw_sigma_after(0.02), expected, 0.02 * expected);
  EXPECT_NEAR(yaw_sigma_after(0.04), 2.0 * expected, 0.02 * expected);
}

}  // namespace
}  // namespace odomd::estimator::testing::kinematic_filter_test
