#include "estimator/baselines/wheel_speed.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "estimator/common/time.hpp"

namespace odomd::estimator {
namespace {

constexpr std::array wheel_sources{Source::wheel_front_left, Source::wheel_front_right,
                                   Source::wheel_rear_left,  Source::wheel_rear_right,
                                   Source::wheel_rear,       Source::motor};

std::int64_t newest_sample_ns(const HeldSignals& held) noexcept {
  std::int64_t newest = std::numeric_limits<std::int64_t>::min();
  for (const Source source : wheel_sources) {
    if (held.seen(source)) {
      newest = std::max(newest, held.time_ns(source));
    }
  }
  return newest;
}

double mean_sigma(double a, double b) noexcept {
  return 0.5 * std::hypot(a, b);
}

}  // namespace

std::optional<AxleSpeed> rear_axle_speed(const Vehicle& car, const HeldSignals& held,
                                         double yaw_rate) noexcept {
  const std::int64_t newest = newest_sample_ns(held);
  const auto alive = [&](Source source) {
    return held.seen(source) &&
           seconds_between(held.time_ns(source), newest) <= wheel_source_timeout_s;
  };
  const bool reversing = held.value(Source::direction) < 0.0;
  const auto speed = [&](Source source) {
    const double value = held.value(source);
    return reversing ? -std::abs(value) : value;
  };
  const double turn = yaw_rate * car.track_width / 2.0;

  const bool rear_left = alive(Source::wheel_rear_left);
  const bool rear_right = alive(Source::wheel_rear_right);
  if (rear_left && rear_right) {
    return AxleSpeed{
        (speed(Source::wheel_rear_left) + speed(Source::wheel_rear_right)) / 2.0,
        mean_sigma(held.sigma(Source::wheel_rear_left), held.sigma(Source::wheel_rear_right))};
  }
  if (alive(Source::wheel_rear)) {
    return AxleSpeed{speed(Source::wheel_rear), held.sigma(Source::wheel_rear)};
  }
  if (rear_left) {
    return AxleSpeed{speed(Source::wheel_rear_left) + turn, held.sigma(Source::wheel_rear_left)};
  }
  if (rear_right) {
    return AxleSpeed{speed(Source::wheel_rear_right) - turn, held.sigma(Source::wheel_rear_right)};
  }
  if (alive(Source::motor)) {
    return AxleSpeed{speed(Source::motor), held.sigma(Source::motor)};
  }
  const double along = std::cos(held.value(Source::steering));
  const bool front_left = alive(Source::wheel_front_left);
  const bool front_right = alive(Source::wheel_front_right);
  if (front_left && front_right) {
    return AxleSpeed{
        (speed(Source::wheel_front_left) + speed(Source::wheel_front_right)) / 2.0 * along,
        mean_sigma(held.sigma(Source::wheel_front_left), held.sigma(Source::wheel_front_right))};
  }
  if (front_left) {
    return AxleSpeed{speed(Source::wheel_front_left) * along + turn,
                     held.sigma(Source::wheel_front_left)};
  }
  if (front_right) {
    return AxleSpeed{speed(Source::wheel_front_right) * along - turn,
                     held.sigma(Source::wheel_front_right)};
  }
  return std::nullopt;
}

}  // namespace odomd::estimator
