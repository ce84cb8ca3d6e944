// docs/model.md, "Gates and rejection timeouts".
#include "estimator/ekf/plausibility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "estimator/common/time.hpp"
#include "estimator/common/vehicle.hpp"
#include "estimator/ekf/standstill.hpp"

namespace odomd::estimator::full {

namespace {

// Longest time between two consistent samples, and longest time that `rate` is multiplied by [s].
constexpr double longest_agreement_s = 1.5;
constexpr double longest_change_s = 0.3;

// A wheel's sample is current for this long.
constexpr double fresh_s = 0.25;

constexpr int most_counted = 3;

constexpr double largest_change = 2.0;  // by the share, in the unit of the value

bool agree(const Reading& before, const Sample& sample) noexcept {
  const double elapsed_s = seconds_between(before.time_ns, sample.time_ns);
  const Rules change = rules_of(sample.source);
  return before.consistent > 0 && elapsed_s <= longest_agreement_s &&
         std::abs(sample.value[0] - before.value) <=
             change.at_once + std::min(change.share * std::abs(sample.value[0]), largest_change) +
                 change.rate * std::min(elapsed_s, longest_change_s);
}

// Above this speed [m/s] a reversal needs two samples.
constexpr double fastest_reversal = 0.5;
}  // namespace

bool is_current(const State& state, Source wheel, std::int64_t time_ns) noexcept {
  const Reading& reading = state.reading(wheel);
  return reading.consistent > 0 && seconds_between(reading.time_ns, time_ns) <= fresh_s;
}

int consistent_samples(const State& state, const Sample& sample) noexcept {
  int most = 0;
  for (const Source source : all_sources) {
    const Reading& before = state.reading(source);
    if ((source == sample.source || (is_wheel(source) && is_wheel(sample.source))) &&
        agree(before, sample)) {
      most = std::max(most, before.consistent);
    }
  }
  return most;
}

bool ends_pause(const State& state, const Sample& sample, double at_least_s) noexcept {
  const double pause_s = seconds_between(state.reading(sample.source).time_ns, sample.time_ns);
  const double cycle_s = state.integrity.history(sample.source).cycle_s;
  return pause_s > std::max(at_least_s, integrity::patience_s(cycle_s));
}

FirstSpeeds first_speeds(const State& state) noexcept {
  std::array<double, wheel_sources.size()> means{};
  std::size_t wheels = 0;
  FirstSpeeds first;
  for (const Source wheel : wheel_sources) {
    const integrity::SourceHistory& history = state.integrity.history(wheel);
    if (history.seen()) {
      means[wheels++] = history.mean();
      first.samples += history.begun;
    }
  }
  auto* const middle = means.begin() + wheels / 2;
  std::nth_element(means.begin(), middle, means.begin() + wheels);
  first.median = *middle;
  return first;
}

std::int64_t consistent_since_ns(const State& state, const Sample& sample) noexcept {
  std::int64_t since_ns = sample.time_ns;
  for (const Source wheel : wheel_sources) {
    const Reading& before = state.reading(wheel);
    if (agree(before, sample)) {
      since_ns = std::min(since_ns, before.time_ns);
    }
  }
  return since_ns;
}

std::int64_t last_wheel_ns(const State& state) noexcept {
  std::int64_t newest_ns = 0;
  for (const Source wheel : wheel_sources) {
    newest_ns = std::max(newest_ns, state.reading(wheel).fused_ns);
  }
  return newest_ns;
}

double wheel_silence_s(const State& state, std::int64_t time_ns) noexcept {
  double cycle_s = 0.0;
  for (const Source wheel : wheel_sources) {
    cycle_s = std::max(cycle_s, state.integrity.history(wheel).cycle_s);
  }
  const double since_s = seconds_between(last_wheel_ns(state), time_ns);
  return std::max(since_s - integrity::patience_s(cycle_s), 0.0);
}

WheelCount count_wheels(Driven driven, const State& state, const Sample& sample) noexcept {
  const auto reads = [&](Source wheel) {
    return wheel == sample.source ? sample.value[0] : state.reading(wheel).value;
  };
  const auto fresh = [&](Source wheel) {
    return wheel == sample.source || is_current(state, wheel, sample.time_ns);
  };
  const auto turns = [&](Source wheel) { return is_turning(reads(wheel), sample.sigma[0]); };
  const auto dead_band = [&](Source wheel) { return state.standstill.dead_band[index_of(wheel)]; };
  const auto blind = [&](Source wheel) {
    return std::ranges::any_of(wheel_sources, [&](Source other) {
      return fresh(other) && turns(other) && dead_band(other) < dead_band(wheel) &&
             std::abs(reads(other)) < dead_band(wheel);
    });
  };
  WheelCount wheels;
  for (const Source wheel : wheel_sources) {
    if (!fresh(wheel) || (!turns(wheel) && blind(wheel))) {
      continue;
    }
    const double speed = reads(wheel);
    const bool free = !is_driven(driven, wheel);
    if (!turns(wheel)) {
      ++wheels.still;
      wheels.free_still |= free;
      continue;
    }
    if (wheels.turning == 0 || std::abs(speed) < std::abs(wheels.slowest)) {
      wheels.slowest = speed;
    }
    ++wheels.turning;
    wheels.free_turning |= free;
  }
  return wheels;
}

double smallest_dead_band(const State& state) noexcept {
  double smallest = *std::ranges::max_element(state.standstill.dead_band);
  for (const Source wheel : wheel_sources) {
    if (state.reading(wheel).consistent > 0) {
      smallest = std::min(smallest, state.standstill.dead_band[index_of(wheel)]);
    }
  }
  return smallest;
}

bool knows_speed(Driven driven, const State& state) noexcept {
  const std::int64_t camera_ns = state.reading(Source::camera).fused_ns;
  return (camera_ns != 0 && seconds_between(camera_ns, state.time_ns) <= fresh_s) ||
         std::ranges::any_of(wheel_sources, [&](Source wheel) {
           return !is_driven(driven, wheel) && state.integrity.trusted(wheel) &&
                  is_current(state, wheel, state.time_ns);
         });
}

double rear_spin(const Vehicle& car, const State& state) noexcept {
  const double v_x = state.mean[at::v_x];
  double most = 0.0;
  for (const Source wheel : wheel_sources) {
    const bool rear = wheel == Source::motor ? car.driven != Driven::front : !is_front(wheel);
    const SourceFlag flag = state.integrity.flag(wheel);
    if (rear && (flag == SourceFlag::ok || flag == SourceFlag::slipping) &&
        is_current(state, wheel, state.time_ns)) {
      const double rolls = v_x - wheel_place(car, wheel).left * state.mean[at::yaw_rate];
      most = std::max(most, std::abs(state.reading(wheel).value - rolls));
    }
  }
  return std::min(most / std::max(std::abs(v_x), integrity::slowest_rolling), 1.0);
}

void note_reading(State& state, const Sample& sample) noexcept {
  Reading& reading = state.reading(sample.source);
  reading.interval_s =
      reading.consistent > 0 ? seconds_between(reading.time_ns, sample.time_ns) : 0.0;
  reading.consistent = agree(reading, sample) ? std::min(reading.consistent + 1, most_counted) : 1;
  reading.previous = std::exchange(reading.value, sample.value[0]);
  reading.time_ns = sample.time_ns;
  reading.advanced_s = sample.advanced_s;
}

Verdict take_direction(const CarModel& model, State& state, const Sample& sample) noexcept {
  const Reading before = state.reading(Source::direction);
  note_reading(state, sample);
  const double direction = sample.value[0];
  const double v_x = state.mean[at::v_x];
  if (direction == 0.0) {
    if (state.standstill.wheels_still || std::abs(v_x) < integrity::slowest_rolling) {
      state.direction = {true, sample.time_ns, direction};
    }
    return Verdict::fused;
  }
  const bool reversed = direction * (state.direction.value < 0.0 ? -1.0 : 1.0) < 0.0;
  if (reversed && state.moving && !state.standstill.standing && direction * v_x < 0.0) {
    if (std::abs(v_x) > fastest_reversal && direction * before.value <= 0.0) {
      return Verdict::gated;  // a single corrupt frame must not reverse the car
    }
    state.mean.segment<6>(at::v_x) << -v_x, 0.0, state.mean[at::yaw_rate], 0.0, 0.0, 0.0;
    set_off(model, state, 2.0 * v_x);
  }
  state.direction = {true, sample.time_ns, direction};
  return Verdict::fused;
}

bool lost_direction(const State& state) noexcept {
  const integrity::SourceHistory& direction = state.integrity.history(Source::direction);
  return direction.value != 0.0 && state.standstill.wheels_still &&
         direction.begun >= integrity::least_samples && !direction.alive(state.time_ns);
}

}  // namespace odomd::estimator::full
