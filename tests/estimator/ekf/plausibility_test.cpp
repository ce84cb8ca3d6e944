// One corrupt sample among good ones, and the decision between two that contradict each other.
// In power slides, the accelerometers determine the velocity. What counts as a spin.
#include "estimator/ekf/plausibility.hpp"

#include <random>

#include "tests/estimator/signalled_car.hpp"

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

TEST(Plausibility, AStillWheelCountsUnlessTheOtherHasASmallerDeadBand) {
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
    car.drive(silence, {{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}});
    car.drive(5.0, dead);
    EXPECT_NEAR(car.v_x(), 2.0, 0.02) << silence;
    EXPECT_NEAR(car.x(), 2.0 * (10.0 + silence), 0.3) << silence;
    EXPECT_EQ(car.fused[Source::wheel_front_left], 0) << silence;
  }
}

TEST(Plausibility, ASpeedThatIsPolledOnceASecondIsFollowed) {
  Car car;
  for (int second = 0; second < 30; ++second) {
    car.drive(1.0, {{Source::yaw_rate, 0.0}});
    car.push(Source::motor, second < 10 ? 3.0 * second : 30.0);
  }
  EXPECT_NEAR(car.v_x(), 30.0, 0.1);
  EXPECT_NEAR(car.x(), 20.0 * 30.0 + 0.5 * 10.0 * 30.0, 80.0);
}

TEST(Plausibility, FramesThatContradictEachOtherAreNeverForced) {
  // The only wheel messages are random frames that pass the checks.
  const SensorValues silent{{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}};
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
    wrong += std::abs(way) > 3.0 * std::sqrt(car.state.variance(at::x)) ? 1 : 0;
  }
  EXPECT_LE(wrong, 1);
}

TEST(Plausibility, ASourceNeedsConsistentSamplesAfterAGap) {
  Car car = car_after(2.0, straight_at(1.0));
  const SensorValues silent{{Source::accel_x, 0.0}};
  car.drive(3.0, silent);
  EXPECT_EQ(car.push(Source::yaw_rate, 9.0).verdict, Verdict::gated);
  EXPECT_EQ(car.push(Source::wheel_rear, 60.0).verdict, Verdict::gated);
  for (const Verdict verdict : {Verdict::gated, Verdict::gated, Verdict::fused}) {
    car.drive(0.01, silent);
    EXPECT_EQ(car.push(Source::yaw_rate, 0.1).verdict, verdict);
    EXPECT_EQ(car.push(Source::wheel_rear, 1.2).verdict, verdict);
  }
}

TEST(Plausibility, AWildAccelerationIsNotUsed) {
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

TEST(Plausibility, OneGyroReadingDoesNotTurnTheCarEvenIfItPassesTheGate) {
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
  Car car = car_after(2.0, values);
  for (int i = 0; i < 20; ++i) {
    car.drive(0.1, values);
    EXPECT_FALSE(is_taken(car.push(Source::accel_y, i % 2 == 0 ? 7.7 : -6.2).verdict)) << i;
  }
}

/// The driver countersteers: the front wheels roll where their axle moves. The rear wheels spin.
SensorValues sliding(const Eigen::Vector3d& motion, const Eigen::Vector2d& accel, double spin) {
  const Vehicle car;
  const double half = 0.5 * car.track_width * motion[2];
  const double aside = motion[1] + car.front_axle * motion[2];
  return {{Source::yaw_rate, motion[2]},
          {Source::accel_x, accel[0]},
          {Source::accel_y, accel[1]},
          {Source::steering, std::atan(aside / motion[0])},
          {Source::wheel_front_left, std::hypot(motion[0], aside) - half},
          {Source::wheel_front_right, std::hypot(motion[0], aside) + half},
          {Source::wheel_rear_left, spin * motion[0] - half},
          {Source::wheel_rear_right, spin * motion[0] + half}};
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
}  // namespace odomd::estimator::full::testing::plausibility_test
