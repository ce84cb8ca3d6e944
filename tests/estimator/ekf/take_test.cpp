// Applies single samples to a state: which are fused, and the treatment of a sensor that keeps
// disagreeing with the others.
#include "estimator/ekf/take.hpp"

#include <optional>
#include <random>

#include "estimator/common/symmetric3.hpp"
#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::take_test {
namespace {

TEST(Take, TheFirstWheelSpeedThatIsConfirmedStartsTheMotion) {
  Car car = car_after(0.1, {{Source::yaw_rate, 0.0}, {Source::accel_x, 0.0}});
  EXPECT_FALSE(car.state.moving);
  EXPECT_EQ(car.x(), 0.0);
  EXPECT_EQ(car.push(Source::wheel_rear, 2.0).verdict, Verdict::fused);
  EXPECT_FALSE(car.state.moving);
  EXPECT_EQ(car.push(Source::wheel_rear_left, 2.0).verdict, Verdict::fused);
  EXPECT_TRUE(car.state.moving);
  EXPECT_NEAR(car.v_x(), 2.0, 1e-9);
}

// A camera sees the car: a wheel that spins up loses weight and counts as gated, and a gyro that
// measures a lasting turn counts as fused.
TEST(Take, ASlippingWheelLosesItsWeight) {
  Car car;
  const auto seen = [&car](double seconds, const SensorValues& values) {
    for (int i = 0; i < static_cast<int>(50.0 * seconds); ++i) {
      car.drive(0.02, values);
      const double x = 2.0 * seconds_between(0, car.state.time_ns);
      car.state.integrity.add(CameraPose{.capture_ns = car.state.time_ns,
                                         .x = x,
                                         .sigma_x = 0.01,
                                         .sigma_y = 0.01,
                                         .sigma_yaw = 0.01});
    }
  };
  seen(1.0, straight_at(2.0));
  advance(car.context, car.state, car.state.time_ns + period_ns);
  const Judgement judgement = car.push(Source::wheel_rear_left, 4.0);
  EXPECT_EQ(judgement.verdict, Verdict::gated);
  EXPECT_GT(judgement.test_ratio, 1.0);
  EXPECT_GT(judgement.squared_ratio, car.context.model.tuning.wheel_gate);
  EXPECT_EQ(car.state.reading(Source::wheel_rear_left).fused_ns, car.state.time_ns);
  EXPECT_NEAR(car.v_x(), 2.0, 0.02);
  const double slip = 2.0 - 1.5 * gravity * 0.01 - 3.0 * 0.01;
  EXPECT_NEAR(car.state.integrity.slip_sigma(Source::wheel_rear_left), 0.4 * slip, 0.04);
  seen(0.6, straight_at(2.0));
  EXPECT_LT(car.state.integrity.slip_sigma(Source::wheel_rear_left), 0.1) << "it has come back";
  EXPECT_EQ(car.push(Source::wheel_rear_left, 2.0).verdict, Verdict::fused);
}

TEST(Take, NoiseDoesNotCorrectThePitchGradient) {
  // A minute at a constant speed, with the stated noise of wheels and accelerometer.
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 1.0);
  Car car;
  for (int i = 0; i < 200 * 60; ++i) {
    SensorValues values = straight_at(1.5);
    for (auto& [source, value] : values) value += noise(random) * Car::sigmas[index_of(source)];
    car.tick(values);
  }
  EXPECT_NEAR(car.state.slow.mean[slow::pitch_gradient], 0.0, 0.05);
}

/// The car weaves at the limit of its tyres' grip. Returns the rms error of v_y.
double weave(Car& car, double grip, double seconds) {
  Vehicle plant = car.context.model.car;
  plant.grip_front = plant.grip_rear = grip;
  constexpr double dt = 0.005;
  constexpr double speed = 3.0;
  Moving now{.v_x = speed, .stiffness = 1.0};
  double sum = 0.0;
  for (double t = 0.0; t < seconds; t += dt) {
    now.front_wheel = 0.2 * std::sin(3.0 * t);
    const Eigen::Vector3d next = velocity_step(plant, now, dt).velocity;
    car.tick(with(bend_at(speed, next[2]),
                  {{Source::accel_y, (next[1] - now.v_y) / dt + speed * now.yaw_rate},
                   {Source::steering, now.front_wheel}}));
    now.v_y = next[1];
    now.yaw_rate = next[2];
    sum += squared(car.state.mean[at::v_y] - now.v_y) * dt / seconds;
  }
  return std::sqrt(sum);
}

double grip_of(const Car& car) {
  return 1.0 / (usual_softness(0.0) + car.state.slow.mean[slow::softness]);
}

TEST(Take, TyresAtTheirLimitTeachTheirGrip) {
  for (const double grip : {4.0, 5.0, 6.0}) {
    Car car = car_after(1.0, straight_at(3.0));
    weave(car, grip, 20.0);
    EXPECT_NEAR(grip_of(car), grip, 0.3 * grip);
    EXPECT_LT(weave(car, grip, 10.0), 0.15) << grip;
  }
}

TEST(Take, OnlyACameraCorrectsAConfiguredGrip) {
  Car car;
  car.context.model.car.grip_front = car.context.model.car.grip_rear = 6.0;
  car.drive(1.0, straight_at(3.0));
  weave(car, 4.0, 10.0);
  EXPECT_EQ(car.state.slow.mean[slow::softness], 0.0);
}

TEST(Take, ATyreHasMoreGripThanItHasShown) {
  Car car;
  car.state.slow.mean[slow::softness] = 0.3;  // 3 m/s²
  car.drive(3.0, bend_at(4.0, 1.5));          // 6 m/s²
  EXPECT_GT(grip_of(car), 6.5);
}

TEST(Take, TheDistanceBetweenTheFirstTwoWheelSpeedsCounts) {
  Car car;
  car.push(Source::wheel_rear, 10.0);
  car.drive(0.02, {});
  car.push(Source::wheel_rear, 10.0);
  EXPECT_NEAR(car.x(), 0.2, 1e-9);
}

TEST(Take, ThatDistanceIsUncertain) {
  // Two corrupt frames that happen to agree.
  Car car;
  car.push(Source::wheel_rear, 40.0);
  advance(car.context, car.state, car.state.time_ns + 100 * millisecond);
  car.push(Source::wheel_rear, 38.0);
  ASSERT_TRUE(car.state.moving);
  EXPECT_GT(car.x(), 3.0);
  EXPECT_LT(car.x(), 3.0 * std::sqrt(car.state.variance(at::x)));
}

TEST(Take, ADriveWithoutFaultsIsFollowedAndNothingIsGated) {
  for (const double speed : {0.5, 1.5, 3.0, -2.0}) {
    Car car = car_after(5.0, straight_at(speed));
    EXPECT_TRUE(car.gated.empty()) << speed;
    EXPECT_NEAR(car.v_x(), speed, 0.01) << speed;
    EXPECT_NEAR(car.x(), 5.0 * speed, 0.03 + 0.01 * std::abs(speed)) << speed;
  }
}

TEST(Take, AWheelThatSpinsOrLocksIsLeftOutWhileOthersRoll) {
  for (const auto& [wheel, speed, flag] :
       {std::tuple(Source::wheel_rear_left, 3.0, SourceFlag::slipping),
        {Source::wheel_front_right, 0.0, SourceFlag::frozen}}) {
    SCOPED_TRACE(source_names[index_of(wheel)]);
    Car car = car_after(2.0, straight_at(1.0));
    const double x = car.x();
    car.drive(2.0, with(straight_at(1.0), wheel, speed));
    EXPECT_EQ(car.fused[wheel], 0);
    EXPECT_EQ(car.gated[Source::wheel_rear_right], 0);
    EXPECT_EQ(car.gated[Source::wheel_front_left], 0);
    EXPECT_FALSE(car.stands());
    EXPECT_EQ(car.state.integrity.flag(wheel), flag);
    EXPECT_FALSE(car.state.doubtful);
    EXPECT_NEAR(car.v_x(), 1.0, 0.02);
    EXPECT_NEAR(car.x() - x, 2.0, 0.03);
    car.drive(1.2, straight_at(1.0));  // after a while the wheel counts again
    car.drive(0.5, straight_at(1.0));
    EXPECT_EQ(car.gated[wheel], 0);
  }
}

TEST(Take, ACalmWheelMayBecomeAsNoisyAsTheOthers) {
  // At 20 m/s, calm wheels are precise to 1 cm/s, others to 5 cm/s.
  Car calm = car_after(20.0, straight_at(20.0));
  const double& noise_scale = calm.state.reading(Source::wheel_rear_left).noise_scale;
  ASSERT_LT(noise_scale, 0.1);
  EXPECT_EQ(calm.push(Source::wheel_rear_left, 20.5).verdict, Verdict::fused);
  EXPECT_GE(noise_scale, 1.0);
  EXPECT_EQ(calm.push(Source::wheel_rear_right, 23.0).verdict, Verdict::gated);
}

TEST(Take, AllWheelsTogetherAreAcceptedAfterAWhile) {
  // No car can jump from 1 m/s to 3 m/s without a measured acceleration.
  Car car = car_after(2.0, straight_at(1.0));
  car.drive(0.2, straight_at(3.0));
  EXPECT_NEAR(car.v_x(), 1.0, 0.05);
  EXPECT_EQ(car.fused[Source::wheel_rear_left] + car.fused[Source::wheel_front_left], 0);
  EXPECT_TRUE(car.state.doubtful);
  // The integrated acceleration is precise only for a short time.
  car.drive(8.0, straight_at(3.0));
  EXPECT_NEAR(car.v_x(), 3.0, 0.1);
  car.drive(1.0, straight_at(3.0));
  EXPECT_EQ(car.gated[Source::wheel_rear_left], 0);
}

TEST(Take, SettingOffBeforeAWheelTurnsIsNoTestOfTheAccelerometer) {
  Car car = car_at_rest(2.0);
  const Judgement early = car.push(Source::accel_x, 2.0);
  EXPECT_EQ(early.verdict, Verdict::gated);
  EXPECT_EQ(early.degrees, 0);
  EXPECT_NEAR(car.state.mean[at::accel_bias_x], 0.0, 0.05);
  // A sample that is consistent with the standstill is tested as usual.
  EXPECT_EQ(car.push(Source::accel_x, 0.0).degrees, 1);
}

TEST(Take, NothingIsFusedBeforeTheMotionStarts) {
  // On a circle, with IMU samples long before the first wheel sample.
  Car car;
  const SensorValues imu{{Source::yaw_rate, 1.0},
                         {Source::accel_x, 0.0},
                         {Source::accel_y, 1.5},
                         {Source::steering, 0.175}};
  car.drive(2.0, imu);
  EXPECT_EQ(car.state.mean[at::accel_bias_y], 0.0);
  car.drive(1.0, with(imu, Source::motor, 1.5));
  EXPECT_TRUE(car.gated.empty());
  EXPECT_NEAR(car.yaw(), 1.0, 0.05);
  EXPECT_NEAR(car.state.mean[at::accel_bias_y], 0.0, 0.3);
}

TEST(Take, AForcedLateralAccelerationDoesNotMoveASlowCar) {
  Car car = car_after(2.0, straight_at(0.05));
  ASSERT_FALSE(car.stands());
  const double force = car.state.variance(at::front_angle);
  car.drive(1.0, with(straight_at(0.05), Source::accel_y, 6.0));
  EXPECT_LT(car.state.variance(at::front_angle), 1.5 * force);
  EXPECT_NEAR(car.yaw(), 0.0, 1e-3);
  EXPECT_NEAR(car.state.mean[at::y], 0.0, 1e-2);
}

TEST(Take, WithoutAGyroTheWheelsMeasureTheYawRate) {
  const double half_track = 0.5 * Vehicle{}.track_width;
  const Car car = car_after(4.0, {{Source::wheel_rear_left, 1.5 - half_track},
                                  {Source::wheel_rear_right, 1.5 + half_track}});
  EXPECT_NEAR(car.yaw_rate(), 1.0, 0.1);
  EXPECT_NEAR(car.v_x(), 1.5, 0.02);
}

/// A direction, if any, its verdict, and the speed after driving on with these wheels.
struct Directed {
  std::optional<double> direction;
  double seconds;
  double wheels;
  double v_x;
  Verdict verdict = Verdict::fused;
};

TEST(Take, ADirectionGivesWheelSpeedsTheirSign) {
  const std::pair<const char*, std::vector<Directed>> cases[] = {
      {"unsigned wheels in reverse", {{-1.0, 3.0, 1.0, -1.0}}},
      {"forward leaves signs alone", {{1.0, 1.0, -0.7, -0.7}}},
      {"so does unknown", {{0.0, 1.0, -0.7, -0.7}}},
      {"a late one turns the speed at once", {{1.0, 1.0, 0.3, 0.3}, {-1.0, 0.03, 0.3, -0.3}}},
      {"of an unknown one the last counts until the car stands",
       {{-1.0, 1.0, 0.4, -0.4},
        {0.0, 0.5, 0.4, -0.4},
        {std::nullopt, 1.0, 0.0, 0.0},
        {0.0, 1.0, 0.4, 0.4}}},
      {"one corrupt frame does not reverse a moving car",
       {{1.0, 1.0, 1.5, 1.5},
        {-1.0, 0.1, 1.5, 1.5, Verdict::gated},
        {1.0, 0.1, 1.5, 1.5},
        {-1.0, 0.0, 1.5, 1.5, Verdict::gated},
        {-1.0, 0.1, 1.5, -1.5}}},
  };
  for (const auto& [name, steps] : cases) {
    SCOPED_TRACE(name);
    Car car;
    double way = 0.0;
    for (const auto& [direction, seconds, wheels, v_x, verdict] : steps) {
      EXPECT_EQ(direction ? car.push(Source::direction, *direction).verdict : verdict, verdict);
      car.drive(seconds, straight_at(wheels));
      EXPECT_NEAR(car.v_x(), v_x, 0.03);
      way += seconds * v_x;
    }
    EXPECT_NEAR(car.x(), way, 0.04 + 0.01 * static_cast<double>(steps.size()));
  }
}

TEST(Take, AReversalReversesTheMotion) {
  // A turn in reverse that was taken for a forward turn, with wrong side forces.
  Car car;
  const SensorValues turn = with(straight_at(0.45), Source::yaw_rate, 0.3);
  car.push(Source::direction, 1.0);
  car.drive(0.3, turn);
  car.push(Source::direction, -1.0);
  car.drive(0.05, turn);
  EXPECT_NEAR(car.v_x(), -0.45, 0.05);
  EXPECT_LT(car.gated[Source::wheel_rear_left], 2);
}

TEST(Take, ASteeringJumpMayBeACorruptFrame) {
  const auto unknown_after = [](double angle) {
    Car car = car_after(3.0, straight_at(1.0));
    car.tick(with(straight_at(1.0), Source::steering, angle));
    return std::sqrt(car.state.variance(at::front_angle));
  };
  EXPECT_LT(unknown_after(0.05), 0.05);  // a driver steers like this
  EXPECT_GT(unknown_after(-0.5), 0.3);
}

TEST(Take, OldInputsAreIgnored) {
  State state;
  state.time_ns = 1'000 * millisecond;
  EXPECT_FALSE(input_of(state).has_steering);
  state.steering = {true, state.time_ns, 0.2};
  state.front_wheels = 0.2;
  EXPECT_TRUE(input_of(state).has_steering);
  EXPECT_EQ(input_of(state).steering, 0.2);
  state.time_ns += 5'000 * millisecond;
  EXPECT_FALSE(input_of(state).has_steering);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::take_test
