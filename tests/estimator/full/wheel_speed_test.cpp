// The prediction of a wheel's speed: each wheel at its place, what it teaches, and what it counts
// as known.
#include "estimator/ekf/wheel_speed.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

#include "derivatives.hpp"
#include "estimator/take.hpp"
#include "states.hpp"

namespace odomd::estimator::full::wheel_speed_test {
namespace {

constexpr double sigma = 0.02;
constexpr std::array sources{Source::wheel_front_left, Source::wheel_front_right,
                             Source::wheel_rear_left,  Source::wheel_rear_right,
                             Source::wheel_rear,       Source::motor};

TEST(FullWheelSpeed, EveryWheelIsAtItsCornerOfTheCar) {
  const Vehicle car;
  for (const Source source : sources) {
    const WheelPlace place = wheel_place(car, source);
    const bool front = source == Source::wheel_front_left || source == Source::wheel_front_right;
    const bool left = source == Source::wheel_front_left || source == Source::wheel_rear_left;
    const bool middle = source == Source::wheel_rear || source == Source::motor;
    EXPECT_EQ(place.ahead, front ? car.front_axle : -car.rear_axle);
    EXPECT_EQ(place.left, middle ? 0.0 : (left ? 0.5 : -0.5) * car.track_width);
    EXPECT_EQ(place.steered, front);
    EXPECT_EQ(is_driven(source), !front);
  }
}

TEST(FullWheelSpeed, IsTheScaledVelocityOfItsPlaceAlongTheWheel) {
  const CarModel model;
  for (const State& state : testing::grid_of_states()) {
    for (const Source source : sources) {
      // (v_x, v_y, 0) + (0, 0, ψ̇) × (x_w, y_w, 0), on the wheel's direction
      const WheelPlace place = wheel_place(model.car, source);
      const double delta = place.steered ? state.steering.value - 0.01 : 0.0;
      const Eigen::Vector2d velocity(state.mean[at::v_x] - state.mean[at::yaw_rate] * place.left,
                                     state.mean[at::v_y] + state.mean[at::yaw_rate] * place.ahead);
      const double along = velocity.dot(Eigen::Vector2d(std::cos(delta), std::sin(delta)));
      EXPECT_NEAR(predict_wheel_speed(model, {}, input_of(state), state, source, sigma, true).value,
                  1.015 * along, 1e-12);
    }
  }
}

TEST(FullWheelSpeed, TeachesSpeedAndScaleAsDifferencesSay) {
  const CarModel model;
  for (const State& state : testing::grid_of_states()) {
    for (const Source source : sources) {
      for (const bool gyro : {true, false}) {
        const auto predict = [&](const State& at) {
          return predict_wheel_speed(model, {}, input_of(at), at, source, sigma, gyro);
        };
        Vector expected = testing::differences(state, predict);
        // Left out on purpose: the side slip, the offset of the steering, and with a gyro alive the
        // yaw rate.
        expected[at::v_y] = 0.0;
        expected[at::steering_offset] = 0.0;
        if (gyro) {
          expected[at::yaw_rate] = 0.0;
        }
        EXPECT_LT((testing::stated(predict(state)) - expected).cwiseAbs().maxCoeff(), 1e-7);
      }
    }
  }
}

TEST(FullWheelSpeed, WhatCountsAsKnownDoesSoWithItsVariance) {
  const CarModel model;
  for (const State& state : testing::grid_of_states()) {
    for (const Source source : sources) {
      const auto predict = [&](const State& at) {
        return predict_wheel_speed(model, {}, input_of(at), at, source, sigma, true);
      };
      const Vector by = testing::differences(state, predict);
      for (const at::Index known : {at::v_y, at::yaw_rate}) {
        State uncertain = state;
        uncertain.covariance(known, known) += 0.09;
        // The scale's percent does not count here.
        const double through = by[known] / 1.015;
        EXPECT_NEAR(predict(uncertain).variance - predict(state).variance, 0.09 * through * through,
                    1e-8);
      }
    }
  }
}

TEST(FullWheelSpeed, IsNeverTakenForBetterThanItsSensor) {
  const CarModel model;
  for (const State& state : testing::grid_of_states()) {
    for (const Source source : sources) {
      EXPECT_GE(
          predict_wheel_speed(model, {}, input_of(state), state, source, sigma, true).variance,
          sigma * sigma);
    }
  }
}

TEST(FullWheelSpeed, WithoutASteeringThatIsHeardAFrontWheelRollsWhereItGoes) {
  const CarModel model;
  State state;
  state.mean[at::v_x] = 2.0;
  state.mean[at::yaw_rate] = 3.0;
  state.steering = {true, 0, -0.4};  // long ago
  const double across = model.car.front_axle * 3.0;
  const double half_track = 0.5 * model.car.track_width;
  const double delta = std::atan(across / 2.0);
  for (const auto& [source, left] : {std::pair(Source::wheel_front_left, half_track),
                                     std::pair(Source::wheel_front_right, -half_track)}) {
    const double along = 2.0 - left * 3.0;
    EXPECT_NEAR(predict_wheel_speed(model, {}, Input{}, state, source, sigma, true).value,
                along * std::cos(delta) + across * std::sin(delta), 1e-12);
  }
  state.mean[at::v_x] = 0.0;
  EXPECT_NEAR(
      predict_wheel_speed(model, {}, Input{}, state, Source::wheel_front_left, sigma, true).value,
      -half_track * 3.0, 1e-12);
}

TEST(FullWheelSpeed, AnAccelerationThatIsHeardNoLongerSlipsNoWheel) {
  const CarModel model;
  State state;
  state.mean[at::v_x] = 2.0;
  const auto variance = [&](const Input& input) {
    return predict_wheel_speed(model, {}, input, state, Source::wheel_rear, sigma, true).variance;
  };
  EXPECT_EQ(variance({.accel_x = 8.0}), variance({}));
  EXPECT_GT(variance({.accel_x = 8.0, .has_accel_x = true}), variance({}));
}

TEST(FullWheelSpeed, SlipsWithTheAccelerationMoreWhereItDrives) {
  const CarModel model;
  State state;
  state.mean[at::v_x] = 2.0;
  const auto variance = [&](Source source, double accel_x) {
    state.accel_x = {true, 0, accel_x};
    return predict_wheel_speed(model, {}, input_of(state), state, source, sigma, true).variance;
  };
  for (const Source source : sources) {
    EXPECT_GT(variance(source, 3.0), variance(source, 0.0));
    EXPECT_GT(variance(source, -3.0), variance(source, 0.0));
  }
  EXPECT_GT(variance(Source::wheel_rear_left, 3.0), variance(Source::wheel_front_left, 3.0));
}

TEST(FullWheelSpeed, NoAccelerometerMakesWheelsWorthless) {
  const CarModel model;
  State state;
  state.mean[at::v_x] = 2.0;
  for (const double broken : {-157.0, 50.0, 157.0}) {
    const Input input{.accel_x = broken, .has_accel_x = true};
    const Prediction z =
        predict_wheel_speed(model, {}, input, state, Source::wheel_rear, sigma, true);
    EXPECT_LT(std::sqrt(z.variance), 0.5);
  }
}

}  // namespace
}  // namespace odomd::estimator::full::wheel_speed_test
