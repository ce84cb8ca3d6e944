// Passes the samples of a simulated car to one state of the filter, tick by tick.
#pragma once

#include <concepts>
#include <map>

#include "estimator/ekf/publication.hpp"
#include "estimator/ekf/take.hpp"
#include "tests/estimator/drive.hpp"
#include "tests/estimator/ekf/states.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing {

using estimator::testing::millisecond;
using estimator::testing::period_ns;

/// Values of the sensors; a sensor without a value sends nothing.
using SensorValues = std::map<Source, double>;

/// Drives a car, a tick at a time; counts each source's fused and gated samples.
class Car {
 public:
  Car() {
    state.time_ns = 1'000 * millisecond;
    state.located = true;
    context.model.gyro_sigma = sigmas[index_of(Source::yaw_rate)];
  }

  Judgement push(Source source, double value) {
    const Judgement judgement = take(context, state,
                                     {.time_ns = state.time_ns,
                                      .source = source,
                                      .value = {value},
                                      .sigma = {sigmas[index_of(source)]}});
    ++(is_taken(judgement.verdict) ? fused : gated)[source];
    return judgement;
  }

  void tick(const SensorValues& values) {
    advance(context, state, state.time_ns + period_ns);
    for (const auto& [source, value] : values) {
      if (!is_wheel(source) || state.time_ns % (2 * period_ns) == 0)
        push(source, value + (is_inertial(source) ? tremor() : 0.0));
    }
    apply_integrity(context, state);
    ASSERT_TRUE(has_covariances(state));
  }

  /// Resets the counts, then drives for `seconds`; `values_at(t)` gives the values t seconds from
  /// now.
  template <std::invocable<double> ValuesAt>
  void drive(double seconds, const ValuesAt& values_at) {
    fused.clear();
    gated.clear();
    for (int i = 0; i < std::lround(200.0 * seconds); ++i) tick(values_at(0.005 * i));
  }
  void drive(double seconds, const SensorValues& values) {
    drive(seconds, [&](double) { return values; });
  }

  [[nodiscard]] double x() const { return state.mean[at::x]; }
  [[nodiscard]] double v_x() const { return state.mean[at::v_x]; }
  [[nodiscard]] double yaw() const { return state.mean[at::yaw]; }
  [[nodiscard]] double yaw_rate() const { return state.mean[at::yaw_rate]; }
  [[nodiscard]] double gyro_bias() const { return state.slow.mean[slow::gyro_bias]; }
  [[nodiscard]] bool stands() const { return state.standstill.standing; }

  /// Added to inertial signals: a real sensor never repeats a value exactly.
  [[nodiscard]] double tremor() const {
    return state.time_ns % (2 * period_ns) == 0 ? 1e-9 : -1e-9;
  }

  static constexpr std::array<double, source_count> sigmas{0.01, 0.1,  0.1,  0.01,  0.01, 0.01,
                                                           0.01, 0.01, 0.01, 0.005, 1.0,  1.0};
  Context context;
  State state = initial_state({});
  std::map<Source, int> fused;
  std::map<Source, int> gated;
};

/// A car that has driven for `seconds`.
inline Car car_after(double seconds, const SensorValues& values) {
  Car car;
  car.drive(seconds, values);
  return car;
}

inline SensorValues straight_at(double speed, double accel = 0.0) {
  return {{Source::yaw_rate, 0.0},
          {Source::accel_x, accel},
          {Source::accel_y, 0.0},
          {Source::steering, 0.0},
          {Source::wheel_front_left, speed},
          {Source::wheel_front_right, speed},
          {Source::wheel_rear_left, speed},
          {Source::wheel_rear_right, speed}};
}

inline Car car_at_rest(double seconds = 3.0) {
  Car car = car_after(seconds, straight_at(0.0));
  EXPECT_TRUE(car.stands());
  return car;
}

/// The signals on a circle to the left, without slip.
inline SensorValues bend_at(double speed, double yaw_rate) {
  const Vehicle car;
  const double half = 0.5 * car.track_width * yaw_rate;
  const double across = car.wheelbase() * yaw_rate;
  return {{Source::yaw_rate, yaw_rate},
          {Source::accel_x, 0.0},
          {Source::accel_y, speed * yaw_rate},
          {Source::steering, std::atan2(speed < 0.0 ? -across : across, std::abs(speed))},
          {Source::wheel_front_left, std::hypot(speed - half, across)},
          {Source::wheel_front_right, std::hypot(speed + half, across)},
          {Source::wheel_rear_left, speed - half},
          {Source::wheel_rear_right, speed + half}};
}

inline SensorValues with(const SensorValues& values, SensorValues changes) {
  changes.insert(values.begin(), values.end());
  return changes;
}
inline SensorValues with(const SensorValues& values, Source source, double value) {
  return with(values, {{source, value}});
}

inline SensorValues without(SensorValues values, std::same_as<Source> auto... sources) {
  (values.erase(sources), ...);
  return values;
}

}  // namespace odomd::estimator::full::testing
