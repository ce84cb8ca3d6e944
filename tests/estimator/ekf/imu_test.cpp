// Compares the predictions of gyro and accelerometers with the model and with central differences.
#include "estimator/ekf/measurement_models.hpp"

#include "derivatives.hpp"
#include "estimator/common/vehicle.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing::imu_test {
namespace {

constexpr double dt = 0.005;
constexpr double sigma = 0.3;

CarModel car_with_imu_off_centre() {
  CarModel model;
  model.imu_position = {0.04, 0.015};
  return model;
}

Input input_at(const State& state, bool steering) {
  return {state.steering.value, steering};
}

bool resolved(const CarModel& model, const State& state) {
  return std::abs(state.mean[at::v_x]) >= slowest_resolved_speed(model.car, dt);
}

TEST(Gyro, IsScaledAndBiased) {
  for (const State& state : grid_of_states()) {
    const Prediction z = predict_yaw_rate(state, 0.03);
    EXPECT_NEAR(z.value, 1.01 * state.mean[at::yaw_rate] + 0.02, 1e-15);
    EXPECT_EQ(z.variance, 0.03 * 0.03);
    EXPECT_EQ(z.slack, 0.0);
    expect_derivatives(
        state, [](const State& at) { return predict_yaw_rate(at, 0.03); }, 5e-9);
  }
}

TEST(AccelX, IsTheForceAtTheImuScaledAndBiased) {
  const CarModel model = car_with_imu_off_centre();
  for (State state : grid_of_states()) {
    const double yaw_rate = state.mean[at::yaw_rate];
    EXPECT_NEAR(predict_accel_x(model, state, sigma).value,
                0.97 * (0.6 - yaw_rate * yaw_rate * 0.04) - 0.08, 1e-14);
    EXPECT_EQ(predict_accel_x(model, state, sigma).variance, sigma * sigma);
    state.standstill.standing = true;
    EXPECT_EQ(predict_accel_x(model, state, sigma).value, -0.08);
  }
}

TEST(AccelX, StatesItsDerivatives) {
  const CarModel model = car_with_imu_off_centre();
  for (State state : grid_of_states()) {
    for (const bool standing : {false, true}) {
      state.standstill.standing = standing;
      const auto predict = [&](const State& at) { return predict_accel_x(model, at, sigma); };
      // The yaw rate is left out on purpose: the gyro measures it better.
      expect_derivatives(state, predict, 5e-9, {at::yaw_rate});
    }
  }
}

TEST(AccelY, StatesItsDerivatives) {
  const CarModel model = car_with_imu_off_centre();
  for (const bool steering : {true, false}) {
    for (State state : grid_of_states()) {
      state.slow.mean[slow::softness] = -1.0;  // linear tyres
      if (!resolved(model, state)) continue;
      const auto predict = [&](const State& at) {
        Prediction z = predict_accel_y(model, input_at(state, steering), at, sigma, dt);
        z.by_slow[slow::softness] = 0.0;
        return z;
      };
      expect_derivatives(state, predict, 1e-6);
    }
  }
}

TEST(AccelY, IsTheForceOfTheTyresOverTheMassAtTheImu) {
  // On a steady circle ψ̈ = 0, and the force is m v_x ψ̇.
  CarModel model = car_with_imu_off_centre();
  State state;
  const Input input{0.1, true};
  const auto step = [&] { return velocity_step(model.car, moving(state, input), dt).velocity; };
  state.mean[at::v_x] = 1.5;
  for (int i = 0; i < 2000; ++i) {
    state.mean.segment<3>(at::v_x) = step();
    state.mean[at::v_x] = 1.5;
  }
  const double yaw_rate = state.mean[at::yaw_rate];
  ASSERT_GT(yaw_rate, 0.3);
  state.mean[at::accel_bias_y] = 0.25;
  state.slow.mean[slow::roll_gradient] = 0.1;
  EXPECT_NEAR(predict_accel_y(model, input, state, sigma, dt).value,
              1.1 * (1.5 * yaw_rate - yaw_rate * yaw_rate * 0.015) + 0.25, 1e-6);

  // If the yaw rate changes, an IMU at x ahead of the centre of gravity also measures x ψ̈.
  state.slow.mean.setZero();
  state.mean[at::yaw_rate] = 0.0;
  const double at_imu = predict_accel_y(model, input, state, sigma, dt).value;
  const double yaw_accel = step()[2] / dt;
  model.imu_position = {0.0, 0.0};
  EXPECT_NEAR(at_imu - predict_accel_y(model, input, state, sigma, dt).value, 0.04 * yaw_accel,
              1e-9);
  EXPECT_GT(std::abs(yaw_accel), 1.0);
}

TEST(AccelY, OfSlidingTyresIsTheirGrip) {
  CarModel model;
  model.car.grip_front = model.car.grip_rear = 4.0;
  State state;
  state.mean[at::v_x] = 3.0;
  state.mean[at::v_y] = 3.0;  // sideways
  EXPECT_NEAR(predict_accel_y(model, {0.0, true}, state, sigma, 1e-4).value, -4.0, 0.05);
}

TEST(AccelY, AtWalkingPaceAndStandstillCorrectsItsBiasAlone) {
  const CarModel model = car_with_imu_off_centre();
  Vector bias = Vector::Zero();
  bias[at::accel_bias_y] = 1.0;
  int slow = 0;
  for (State state : grid_of_states()) {
    const Input input = input_at(state, true);
    if (!resolved(model, state)) {
      const Prediction z = predict_accel_y(model, input, state, sigma, dt);
      const double side = state.mean[at::v_x] * state.mean[at::yaw_rate];
      EXPECT_EQ(stated(z), bias);
      // The unmodelled part has a sigma as large as itself.
      EXPECT_NEAR(z.variance, sigma * sigma + side * side, 1e-15);
      ++slow;
    }
    state.standstill.standing = true;
    const Prediction z = predict_accel_y(model, input, state, sigma, dt);
    EXPECT_EQ(stated(z), bias);
    EXPECT_EQ(z.by_slow, SlowVector(SlowVector::Zero()));
    EXPECT_EQ(z.value, state.mean[at::accel_bias_y]);
    EXPECT_EQ(z.variance, sigma * sigma);
  }
  EXPECT_GT(slow, 50);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::imu_test
