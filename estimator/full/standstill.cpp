#include "estimator/full/standstill.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/full/prediction.hpp"
#include "estimator/time.hpp"

namespace odomd::estimator::full {
namespace {

// A wheel turns above twice its noise, but not below the first and surely above the second speed.
constexpr double slowest_turning = 0.01;  // [m/s]
constexpr double surely_turning = 0.03;   // [m/s]

// How far a resting gyro swings: this, and six times its noise. A bias drifts with the warmth, so
// what it read is slowly forgotten.
constexpr double quiet_swing = 0.02;  // [rad/s]
constexpr double forgotten = 0.001;   // of the swing, per sample
// More than that is a turn, however steady.
constexpr double largest_gyro_bias = 0.5;  // [rad/s]

/// What is known of the velocity of a car that stands, and of one that has just set off.
constexpr double held_sigma = 1e-4;
constexpr double departing_speed = 0.05;     // [m/s]
constexpr double departing_side = 0.02;      // [m/s]
constexpr double departing_yaw_rate = 0.05;  // [rad/s]

void set_variance(State& state, at::Index index, double sigma) noexcept {
  state.covariance.row(index).setZero();
  state.covariance.col(index).setZero();
  state.covariance(index, index) = sigma * sigma;
}

void begin_rest(Rest& rest, std::int64_t time_ns) noexcept {
  rest.resting = true;
  rest.since_ns = time_ns;
  rest.lowest_gyro = std::numeric_limits<double>::max();
  rest.highest_gyro = std::numeric_limits<double>::lowest();
}

/// v = 0, measured: what is correlated with the velocity learns from it.
void stand(State& state) noexcept {
  state.rest.standing = true;
  for (const at::Index index : {at::v_x, at::v_y, at::yaw_rate}) {
    Prediction zero;
    zero.value = state.mean[index];
    zero.variance = held_sigma * held_sigma;
    zero.depends_on(index, 1.0);
    const Innovation nu = innovation(state, zero, 0.0);
    correct(state, nu, gain_of_own_sensors(state, nu, 0.0, {.yaw_rate = true, .gyro_bias = true}));
  }
  state.mean.segment<5>(at::v_x).setZero();  // v_x, v_y, yaw_rate, front_force, yaw_moment
}

/// The wheels may have been turning for a while below the slowest speed that they resolve.
void set_off(const CarModel& model, State& state, double speed) noexcept {
  state.rest = {};
  set_variance(state, at::v_x, std::max(departing_speed, std::abs(speed)));
  set_variance(state, at::v_y, departing_side);
  set_variance(state, at::yaw_rate, departing_yaw_rate);
  set_variance(state, at::front_force, model.noise.front_force);
  set_variance(state, at::yaw_moment, model.noise.yaw_moment);
}

}  // namespace

bool turns(double speed, double sigma) noexcept {
  return std::abs(speed) > std::clamp(2.0 * sigma, slowest_turning, surely_turning);
}

void rest_by_wheel(const CarModel& model, State& state, std::int64_t time_ns, double speed,
                   double sigma) noexcept {
  Rest& rest = state.rest;
  if (turns(speed, sigma)) {
    if (rest.standing) {
      set_off(model, state, speed);
    }
    rest.resting = false;
  } else if (!rest.resting) {
    begin_rest(rest, time_ns);
  } else if (!rest.standing && seconds_between(rest.since_ns, time_ns) >= standing_after_s) {
    stand(state);
  }
}

void rest_by_gyro(const CarModel& model, State& state, std::int64_t time_ns, double yaw_rate,
                  double sigma) noexcept {
  Rest& rest = state.rest;
  if (!rest.resting) {
    return;
  }
  const bool first = rest.highest_gyro < rest.lowest_gyro;
  const auto after = [&](double extreme) {
    return first ? yaw_rate : extreme + forgotten * (yaw_rate - extreme);
  };
  rest.lowest_gyro = std::min(yaw_rate, after(rest.lowest_gyro));
  rest.highest_gyro = std::max(yaw_rate, after(rest.highest_gyro));
  const double swing = quiet_swing + 6.0 * sigma;
  if (rest.highest_gyro - rest.lowest_gyro <= swing && std::abs(yaw_rate) <= largest_gyro_bias) {
    return;
  }
  if (rest.standing) {
    set_off(model, state, 0.0);
  }
  begin_rest(rest, time_ns);
}

}  // namespace odomd::estimator::full
