// The lateral accelerometer's prediction against the model it is made of and differences.
#include "estimator/ekf/accel_y.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "derivatives.hpp"
#include "estimator/common/dynamic_model.hpp"
#include "states.hpp"

namespace odomd::estimator::full::accel_y_test {
namespace {

constexpr double dt = 0.005;
constexpr double sigma = 0.3;

CarModel car_with_imu_aside() {
  CarModel model;
  model.imu_position = {0.04, 0.015};
  return model;
}

Input input_at(const State& state, bool steering) {
  return {state.steering.value, state.accel_x.value, steering, true};
}

bool resolved(const CarModel& model, const State& state) {
  return std::abs(state.mean[at::v_x]) >= slowest_resolved_speed(model.car, dt);
}

TEST(AccelY, DependsOnTheStateAsItSays) {
  const CarModel model = car_with_imu_aside();
  for (const bool steering : {true, false}) {
    for (const State& state : testing::grid_of_states()) {
      if (!resolved(model, state)) {
        continue;
      }
      const auto predict = [&](const State& at) {
        return predict_accel_y(model, input_at(state, steering), at, sigma, dt);
      };
      const Vector by = testing::stated(predict(state));
      EXPECT_LT((by - testing::differences(state, predict)).cwiseAbs().maxCoeff(),
                1e-6 * (1.0 + by.cwiseAbs().maxCoeff()))
          << state.mean.transpose();
    }
  }
}

TEST(AccelY, IsTheForceOfTheTyresOverTheMassAtTheImu) {
  // On a steady circle ψ̈ = 0, and the force is m v_x ψ̇.
  CarModel model = car_with_imu_aside();
  State state;
  const Input input{0.1, 0.0, true, false};
  state.mean[at::v_x] = 1.5;
  for (int i = 0; i < 2000; ++i) {
    state.mean.segment<3>(at::v_x) = velocity_linearised(model, input, state.mean, dt).velocity;
    state.mean[at::v_x] = 1.5;
  }
  const double yaw_rate = state.mean[at::yaw_rate];
  ASSERT_GT(yaw_rate, 0.3);
  state.mean[at::accel_bias_y] = 0.25;
  EXPECT_NEAR(predict_accel_y(model, input, state, sigma, dt).value,
              1.5 * yaw_rate - yaw_rate * yaw_rate * 0.015 + 0.25, 1e-6);

  // Off the circle the lever arm ahead feels ψ̈.
  state.mean[at::yaw_rate] = 0.0;
  const double at_imu = predict_accel_y(model, input, state, sigma, dt).value;
  const double yaw_accel = velocity_linearised(model, input, state.mean, dt).velocity[2] / dt;
  model.imu_position = {0.0, 0.0};
  EXPECT_NEAR(at_imu - predict_accel_y(model, input, state, sigma, dt).value, 0.04 * yaw_accel,
              1e-9);
  EXPECT_GT(std::abs(yaw_accel), 1.0);
}

TEST(AccelY, AtWalkingPaceAndStandingTeachesItsBiasAlone) {
  const CarModel model = car_with_imu_aside();
  Vector bias = Vector::Zero();
  bias[at::accel_bias_y] = 1.0;
  int slow = 0;
  for (State state : testing::grid_of_states()) {
    const Input input = input_at(state, true);
    if (!resolved(model, state)) {
      const Prediction z = predict_accel_y(model, input, state, sigma, dt);
      EXPECT_EQ(testing::stated(z), bias);
      EXPECT_GT(z.variance, 2.0 * sigma * sigma);  // by what is not modelled
      ++slow;
    }
    state.rest.standing = true;
    const Prediction z = predict_accel_y(model, input, state, sigma, dt);
    EXPECT_EQ(testing::stated(z), bias);
    EXPECT_EQ(z.value, state.mean[at::accel_bias_y]);
    EXPECT_EQ(z.variance, sigma * sigma);
  }
  EXPECT_GT(slow, 50);
}

}  // namespace
}  // namespace odomd::estimator::full::accel_y_test
