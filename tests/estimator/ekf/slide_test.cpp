// Power slides without a camera: the accelerometers carry the velocity. What counts as a spin.
#include "estimator/ekf/plausibility.hpp"
#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::slide_test {
namespace {

/// The driver countersteers: the front wheels roll where their axle moves. The rear wheels spin.
SensorValues sliding(const Eigen::Vector3d& motion, const Eigen::Vector2d& accel, double spin) {
  const Vehicle car;
  const double half = 0.5 * car.track_width * motion[2];
  const double aside = motion[1] + car.front_axle * motion[2];
  return {{{Source::yaw_rate, motion[2]},
           {Source::accel_x, accel[0]},
           {Source::accel_y, accel[1]},
           {Source::steering, std::atan(aside / motion[0])},
           {Source::wheel_front_left, std::hypot(motion[0], aside) - half},
           {Source::wheel_front_right, std::hypot(motion[0], aside) + half},
           {Source::wheel_rear_left, spin * motion[0] - half},
           {Source::wheel_rear_right, spin * motion[0] + half}}};
}

TEST(Slide, TheAccelerometersCarryTheVelocityWhileTheRearWheelsSpin) {
  constexpr double grip = 5.0;  // of tyres that spin [m/s²]
  for (const double side : {1.0, -1.0}) {
    Car car = car_after(1.0, straight_at(0.0));
    Eigen::Vector3d motion = Eigen::Vector3d::Zero();  // v_x, v_y, ψ̇
    double turned = 0.0;
    for (int i = 0; i < 500; ++i) {
      const double t = 0.005 * i - 1.0;  // the slide begins at 0
      const double turn = t < 0.0    ? 0.0
                          : t < 0.35 ? 10.0 * t
                                     : std::max(3.5 - 6.0 * (t - 0.35), 1.8);
      motion[2] = side * turn;
      const double demanded = motion[0] * motion[2];
      const Eigen::Vector2d accel{t < 0.0 ? 3.0 : -motion[1] * motion[2],
                                  std::clamp(demanded, -grip, grip)};
      motion[0] += 0.005 * (accel[0] + motion[1] * motion[2]);
      motion[1] += 0.005 * (accel[1] - demanded);
      turned += 0.005 * motion[2];
      car.tick(sliding(motion, accel, t < 0.0 ? 1.0 : std::min(1.0 + 2.0 * t, 1.7)));
    }
    EXPECT_LT(motion[1] * side, -1.5);
    EXPECT_NEAR(car.v_x(), motion[0], 0.25) << side;
    EXPECT_NEAR(car.state.mean[at::v_y], motion[1], 0.5) << side;
    EXPECT_NEAR(car.yaw(), turned, 0.05) << side;
    EXPECT_TRUE(car.state.integrity.trusted(Source::yaw_rate)) << side;
    EXPECT_TRUE(car.state.integrity.trusted(Source::accel_y)) << side;
  }
}

TEST(Slide, NeitherATightTurnNorTheMotorOfAFrontDrivenCarIsASpinOfTheRearWheels) {
  const Car turning = car_after(3.0, bend_at(1.0, 2.0));
  EXPECT_LT(rear_spin(Vehicle{}, turning.state), 0.03);
  State state;
  state.time_ns = 1;
  state.mean[at::v_x] = 2.0;
  state.reading(Source::motor) = {.consistent = 3, .time_ns = 1, .value = 3.0};
  EXPECT_EQ(rear_spin(Vehicle{}, state), 0.5);
  EXPECT_FALSE(knows_speed(Driven::rear, state));
  EXPECT_EQ(rear_spin({.driven = Driven::front}, state), 0.0);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::slide_test
