// Gates of the car's own sensors, the states that each may correct, and sudden changes.
#include "estimator/ekf/judge.hpp"

#include "estimator/ekf/measurement_models.hpp"
#include "estimator/ekf/publication.hpp"
#include "tests/estimator/ekf/states.hpp"
#include "tests/estimator/signalled_car.hpp"

namespace odomd::estimator::full::testing::judge_test {
namespace {

State on_its_way() {
  State state;
  state.time_ns = 1'000'000'000;
  state.moving = state.located = true;
  state.mean[at::v_x] = 2.0;
  state.mean[at::yaw_rate] = 0.5;
  state.covariance = testing::some_covariance(1e-2);
  state.slow = testing::some_slow_errors(1e-3);
  return state;
}

Sample sample_of(const State& state, Source source, double value) {
  return {.time_ns = state.time_ns, .source = source, .value = {value}, .sigma = {0.02}};
}

TEST(Judge, TheCarsOwnSensorsDoNotMoveThePosition) {
  const CarModel model;
  const Input input{0.1, true};
  State state = on_its_way();
  const Pose2 before = state.pose();
  const auto take = [&](Source source, const Prediction& z, Updates updates) {
    const Judgement judgement =
        judge(model, state, sample_of(state, source, z.value + 0.05), z, updates);
    EXPECT_EQ(judgement.verdict, Verdict::fused);
    EXPECT_EQ(state.mean[at::x], before.x);
    EXPECT_EQ(state.mean[at::y], before.y);
    EXPECT_TRUE(testing::is_covariance(state.covariance));
  };
  take(Source::accel_x, predict_accel_x(model, state, 0.02), {});
  take(Source::accel_y, predict_accel_y(model, input, state, 0.02, 0.005), {});
  take(Source::wheel_rear, predict_wheel_speed(model, input, state, Source::wheel_rear, 0.02, true),
       {});
  EXPECT_EQ(state.mean[at::yaw], before.yaw);
  EXPECT_EQ(state.mean[at::yaw_rate], 0.5);
  take(Source::yaw_rate, predict_yaw_rate(state, 0.02), {.heading = true});
  EXPECT_NE(state.mean[at::yaw_rate], 0.5);
}

TEST(Judge, NeitherATurnNorASideForceSetsTheSpeed) {
  const CarModel model;
  State state = on_its_way();
  const Vector before = state.mean;
  const Prediction turn = predict_yaw_rate(state, 0.02);
  (void)judge(model, state, sample_of(state, Source::yaw_rate, turn.value + 0.1), turn,
              {.heading = true});
  const Prediction force = predict_accel_y(model, {0.1, true}, state, 0.02, 0.005);
  (void)judge(model, state, sample_of(state, Source::accel_y, force.value + 0.1), force, {});
  for (const at::Index index : {at::v_x, at::accel_x, at::accel_bias_x})
    EXPECT_EQ(state.mean[index], before[index]);
  EXPECT_NE(state.mean[at::v_y], before[at::v_y]);
}

TEST(Judge, ASampleCorrectsOnlyItsSlowError) {
  const CarModel model;
  for (const bool standing : {false, true}) {
    State state = on_its_way();
    const SlowVector before = state.slow.mean;
    const Prediction z = predict_yaw_rate(state, 0.02);
    (void)judge(model, state, sample_of(state, Source::yaw_rate, z.value + 0.05), z,
                {.heading = !standing, .slow = standing ? only(slow::gyro_bias) : none()});
    EXPECT_EQ(state.slow.mean[slow::gyro_bias] != before[slow::gyro_bias], standing);
    EXPECT_EQ(state.slow.mean.tail<slow::size - 1>(), before.tail<slow::size - 1>());
  }
}

TEST(Judge, HardBrakingIsFollowed) {
  for (const double braking : {3.0, 5.0, 9.0}) {
    for (const bool accelerometer : {true, false}) {
      SCOPED_TRACE(std::to_string(braking) + (accelerometer ? "" : ", without an accelerometer"));
      const auto going = [&](double speed, double accel) {
        const SensorValues values = straight_at(speed, accel);
        return accelerometer ? values : without(values, Source::accel_x);
      };
      Car car = car_after(3.0, going(2.0, 0.0));
      for (double speed = 2.0; speed > 0.3;) {
        speed -= braking * 0.005;
        car.tick(going(speed, -braking));
        EXPECT_NEAR(car.v_x(), speed, accelerometer ? 0.1 : 0.22);
      }
      if (!accelerometer) continue;
      EXPECT_TRUE(car.gated.empty() || car.gated[Source::wheel_rear_left] <= 2);
      // The braking changes a_x, not bias or pitch gradient; a small part of 9 m/s² may be a slope.
      EXPECT_NEAR(car.state.mean[at::accel_bias_x], 0.0, 0.05 * braking + 0.05);
      EXPECT_NEAR(car.state.slow.mean[slow::pitch_gradient], 0.0, 0.05);
    }
  }
}

TEST(Judge, ASingleFrameDoesNotBrakeTheCar) {
  Car car = car_after(3.0, straight_at(2.0));
  for (const double value : {-6.0, 6.0, -9.0}) {
    car.tick(straight_at(2.0, value));
    EXPECT_NEAR(car.state.mean[at::accel_x], 0.0, 0.1);
    car.drive(0.2, straight_at(2.0));
    EXPECT_TRUE(car.gated.empty());
    EXPECT_NEAR(car.state.mean[at::v_x], 2.0, 0.01);
  }
}

TEST(Judge, RollIsLearntFromTheSideForceAndPitchFromBraking) {
  // A slow error is corrected a little by every bend, and by every stop.
  const Vehicle vehicle;
  const double v = 2.0;
  // ψ̇ of the linear model in a steady turn at 0.1 rad
  const double delta = 0.1;
  const double gradient = vehicle.mass / vehicle.wheelbase() *
                          (vehicle.rear_axle / vehicle.cornering_stiffness_front -
                           vehicle.front_axle / vehicle.cornering_stiffness_rear);
  const double yaw_rate = v * delta / (vehicle.wheelbase() + gradient * v * v);
  Car car;
  for (int i = 0; i < 40; ++i) {
    const double way = i % 2 == 0 ? 1.0 : -1.0;
    const SensorValues turn =
        with(bend_at(v, way * yaw_rate),
             {{Source::steering, way * delta}, {Source::accel_y, way * 1.1 * v * yaw_rate}});
    car.drive(1.0, without(turn, Source::wheel_front_left, Source::wheel_front_right));
  }
  EXPECT_GT(car.state.slow.mean[slow::roll_gradient], 0.03);
  EXPECT_LT(car.state.slow.mean[slow::roll_gradient], 0.2);
  for (const slow::Index error : {slow::gyro_scale, slow::wheel_scale, slow::stiffness_scale})
    EXPECT_EQ(car.state.slow.mean[error], 0.0) << error;

  Car other;
  for (int i = 0; i < 20; ++i) {
    other.drive(1.0, [](double t) { return straight_at(2.0 + 2.0 * t, 1.05 * 2.0); });
    other.drive(1.0, [](double t) { return straight_at(4.0 - 2.0 * t, 1.05 * -2.0); });
  }
  EXPECT_GT(other.state.slow.mean[slow::pitch_gradient], 0.02);
  EXPECT_LT(other.state.slow.mean[slow::pitch_gradient], 0.08);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::judge_test
