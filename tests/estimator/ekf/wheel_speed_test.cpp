// The prediction of a wheel's speed: each wheel at its position, and the derivatives.
#include "estimator/ekf/measurement_models.hpp"

#include "derivatives.hpp"
#include "estimator/ekf/take.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing::wheel_speed_test {
namespace {

/// The grid's states with zero wheel latency: the prediction leaves out the derivatives of the
/// latency correction.
std::vector<State> states_on_time() {
  std::vector<State> states = grid_of_states();
  for (State& state : states) state.slow.mean[slow::wheel_latency] = 0.0;
  return states;
}

constexpr double sigma = 0.02;

/// The prediction as a function of the state, with the state's own input.
auto prediction_of(const CarModel& model, Source source, bool gyro = true) {
  return [&model, source, gyro](const State& at) {
    return predict_wheel_speed(model, input_of(at), at, source, sigma, gyro);
  };
}

/// 1 ± c_s η (a_x + d) of the grid's states, d the drag of the front tyres.
double slip_of(const State& state, Source source) {
  const Vehicle car;
  const double delta = state.front_wheels - 0.01;
  const double drag = car.rear_axle / car.wheelbase() * state.mean[at::v_x] *
                      state.mean[at::yaw_rate] * std::sin(delta);
  const double force = std::copysign(0.6 + drag, (0.6 + drag) * state.mean[at::v_x]);
  return 1.0 + 0.004 * slip_share(Driven::rear, source, force) * force;
}

/// The grid's states with zero wheel slip: the prediction leaves out the slip's derivatives.
std::vector<State> states_without_slip() {
  std::vector<State> states = states_on_time();
  for (State& state : states) state.slow.mean[slow::wheel_slip] = 0.0;
  return states;
}

TEST(FullWheelSpeed, EveryWheelIsAtItsCornerOfTheCar) {
  const Vehicle car;
  for (const Source source : wheel_sources) {
    const WheelPlace place = wheel_place(car, source);
    const bool front = source == Source::wheel_front_left || source == Source::wheel_front_right;
    const bool left = source == Source::wheel_front_left || source == Source::wheel_rear_left;
    const bool middle = source == Source::wheel_rear || source == Source::motor;
    EXPECT_EQ(place.ahead, front ? car.front_axle : -car.rear_axle);
    EXPECT_EQ(place.left, middle ? 0.0 : (left ? 0.5 : -0.5) * car.track_width);
    EXPECT_EQ(place.steered, front);
    EXPECT_EQ(is_driven(Driven::rear, source), !front);
    EXPECT_EQ(is_driven(Driven::front, source), front || source == Source::motor);
    EXPECT_TRUE(is_driven(Driven::all, source));
  }
}

/// The factor due to the difference d = 0.004 of some_slow_values().
double unlike(const WheelPlace& place) {
  return place.left == 0.0 ? 1.0 : 1.0 + std::copysign(0.002, place.left);
}

TEST(FullWheelSpeed, IsTheScaledVelocityOfItsPlaceAlongTheWheel) {
  const CarModel model;
  for (const State& state : states_on_time()) {
    for (const Source source : wheel_sources) {
      // (v_x, v_y, 0) + (0, 0, ψ̇) × (x_w, y_w, 0), projected on the wheel's direction
      const WheelPlace place = wheel_place(model.car, source);
      const double delta = place.steered ? state.steering.value - 0.01 : 0.0;
      const Eigen::Vector2d velocity(state.mean[at::v_x] - state.mean[at::yaw_rate] * place.left,
                                     state.mean[at::v_y] + state.mean[at::yaw_rate] * place.ahead);
      const double along = velocity.dot(Eigen::Vector2d(std::cos(delta), std::sin(delta)));
      EXPECT_NEAR(predict_wheel_speed(model, input_of(state), state, source, sigma, true).value,
                  1.015 * unlike(place) * slip_of(state, source) * along, 1e-12);
    }
  }
}

TEST(FullWheelSpeed, DerivativesBySpeedAndScaleAreRight) {
  const CarModel model;
  for (const State& state : states_without_slip()) {
    for (const Source source : wheel_sources) {
      for (const bool gyro : {true, false}) {
        const auto predict = prediction_of(model, source, gyro);
        // Left out on purpose: the side slip, the steering offset, the effect of a_x on the slip
        // and, if a gyro is alive, the yaw rate.
        expect_derivatives(
            state, predict, 4e-9,
            {at::v_y, at::steering_offset, at::accel_x, gyro ? at::yaw_rate : at::accel_x});
      }
    }
  }
}

TEST(FullWheelSpeed, StatesThatCountAsKnownAddTheirVariance) {
  const CarModel model;
  for (const State& state : states_without_slip()) {
    for (const Source source : wheel_sources) {
      const auto predict = prediction_of(model, source);
      const Vector by = differences(state, predict);
      for (const at::Index known : {at::v_y, at::yaw_rate}) {
        State uncertain = state;
        uncertain.covariance(known, known) += 0.09;
        // The added variance ignores the wheel scales.
        const double through = by[known] / (1.015 * unlike(wheel_place(model.car, source)));
        EXPECT_NEAR(predict(uncertain).variance - predict(state).variance, 0.09 * through * through,
                    1e-8);
      }
    }
  }
}

TEST(FullWheelSpeed, WithoutASteeringSignalAFrontWheelRollsAlongItsVelocity) {
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
    EXPECT_NEAR(predict_wheel_speed(model, Input{}, state, source, sigma, true).value,
                along * std::cos(delta) + across * std::sin(delta), 1e-12);
  }
  state.mean[at::v_x] = 0.0;
  EXPECT_NEAR(
      predict_wheel_speed(model, Input{}, state, Source::wheel_front_left, sigma, true).value,
      -half_track * 3.0, 1e-12);
}

TEST(FullWheelSpeed, DrivenWheelsSlipAndAllSlipHalfAsMuchUnderBraking) {
  CarModel model;
  State state;
  state.slow.mean[slow::wheel_slip] = 0.01;
  for (const Source source : wheel_sources) {
    const auto value = [&](double speed, double accel_x) {
      state.mean[at::v_x] = speed;
      state.mean[at::accel_x] = accel_x;
      return predict_wheel_speed(model, {}, state, source, sigma, true).value;
    };
    model.car.driven = Driven::rear;
    const double driving = is_driven(Driven::rear, source) ? 0.06 : 0.0;
    EXPECT_NEAR(value(2.0, 3.0), 2.0 + driving, 1e-12);
    EXPECT_NEAR(value(-2.0, -3.0), -2.0 - driving, 1e-12);
    EXPECT_NEAR(value(2.0, -3.0), 2.0 - 0.03, 1e-12);
    EXPECT_NEAR(value(-2.0, 3.0), -2.0 + 0.03, 1e-12);
    model.car.driven = Driven::all;
    EXPECT_NEAR(value(2.0, 3.0), 2.06, 1e-12);
    EXPECT_NEAR(value(2.0, -3.0), 1.94, 1e-12);
  }
}

TEST(FullWheelSpeed, DerivativeByAccelerationIncludesTheSlip) {
  const CarModel model;
  for (State state : states_on_time()) {
    state.steering = {};  // no steering, no drag: the derivatives leave drag out
    for (const Source source : wheel_sources) {
      const auto predict = prediction_of(model, source);
      EXPECT_NEAR(stated(predict(state))[at::accel_x], differences(state, predict)[at::accel_x],
                  1e-7);
    }
  }
}

TEST(FullWheelSpeed, ASlippingWheelCountsLessIfAnUndrivenOneIsAlive) {
  CarModel model;
  State state;
  state.mean[at::v_x] = 20.0;
  state.mean[at::accel_x] = 6.0;
  const auto gained = [&](Source source) {
    const Prediction z = predict_wheel_speed(model, {}, state, source, sigma, true);
    return z.variance - z.slack;
  };
  const double alone = gained(Source::wheel_rear_left);
  state.reading(Source::wheel_front_left) = {.consistent = 1};
  EXPECT_GT(gained(Source::wheel_rear_left), 10.0 * alone);
  // If all wheels brake or all are driven, none rolls freely.
  state.mean[at::accel_x] = -6.0;
  EXPECT_EQ(gained(Source::wheel_rear_left), alone);
  state.mean[at::accel_x] = 6.0;
  model.car.driven = Driven::all;
  EXPECT_EQ(gained(Source::wheel_rear_left), alone);
}

TEST(FullWheelSpeed, TheBestWheelKeepsItsFullWeight) {
  const CarModel model;
  State state;
  state.mean[at::v_x] = 10.0;
  const double radius = std::pow(model.tuning.wheel_radius * 10.0, 2);
  const auto left = index_of(Source::wheel_rear_left);
  const auto right = index_of(Source::wheel_rear_right);
  state.readings[left].consistent = state.readings[right].consistent = 3;
  const auto predict = [&](Source source) {
    return predict_wheel_speed(model, {}, state, source, sigma, true);
  };
  EXPECT_EQ(predict(Source::wheel_rear_left).slack, 0.0);

  // If one wheel errs, it has less weight.
  state.readings[left].noise_scale = 9.0;
  EXPECT_NEAR(predict(Source::wheel_rear_left).variance, sigma * sigma + 9.0 * radius, 1e-12);
  EXPECT_EQ(predict(Source::wheel_rear_left).slack, 0.0);
  EXPECT_NEAR(predict(Source::wheel_rear_right).variance, sigma * sigma + radius, 1e-12);

  // If all err, they are inconsistent with each other, but the best one determines the speed.
  state.readings[right].noise_scale = 4.0;
  EXPECT_NEAR(predict(Source::wheel_rear_right).slack, 3.0 * radius, 1e-12);
  EXPECT_NEAR(predict(Source::wheel_rear_left).slack, (9.0 - 9.0 / 4.0) * radius, 1e-12);

  // A calm wheel keeps its small error.
  state.readings[left].noise_scale = 0.1;
  EXPECT_NEAR(predict(Source::wheel_rear_left).variance, sigma * sigma + 0.1 * radius, 1e-12);
  EXPECT_EQ(predict(Source::wheel_rear_left).slack, 0.0);
  EXPECT_EQ(predict(Source::wheel_rear_right).slack, 0.0);
}

}  // namespace
}  // namespace odomd::estimator::full::testing::wheel_speed_test
