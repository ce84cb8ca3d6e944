#include "estimator/baselines/signals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/common/time.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator {

HeldSignals::HeldSignals(const std::array<double, source_count>& sigma) noexcept {
  for (std::size_t i = 0; i < source_count; ++i) {
    held_[i].sigma = sigma_[i] = sigma[i] > 0.0 ? sigma[i] : default_sigma[i];
  }
}

Verdict HeldSignals::take(const Measurement& sample, std::int64_t latest_ns) noexcept {
  if (const std::optional<Verdict> refused = refusal(sample)) {
    return *refused;
  }
  if (sample.time_ns > latest_ns) {
    return Verdict::future;
  }
  const std::size_t index = index_of(sample.source);
  HeldSignal& held = held_[index];
  if (held.seen && sample.time_ns <= held.time_ns) {
    return sample.time_ns == held.time_ns ? Verdict::duplicate : Verdict::too_old;
  }
  const double sigma = sample.sigma > 0.0 ? sample.sigma : sigma_[index];
  held = {true, sample.time_ns, sample.value, std::min(sigma, physical_limit[index])};
  return Verdict::fused;
}

std::optional<AxleSpeed> rear_axle_speed(const Vehicle& car, const HeldSignals& held,
                                         double car_yaw_rate) noexcept {
  constexpr double silent_after_s = 0.5;
  std::int64_t newest_ns = std::numeric_limits<std::int64_t>::min();
  for (std::size_t i = 0; i < source_count; ++i) {
    const HeldSignal& signal = held[static_cast<Source>(i)];
    if (is_wheel(static_cast<Source>(i)) && signal.seen) {
      newest_ns = std::max(newest_ns, signal.time_ns);
    }
  }
  const auto alive = [&](Source source) {
    return held[source].seen && seconds_between(held[source].time_ns, newest_ns) <= silent_after_s;
  };
  const auto speed = [&, reversing = held[Source::direction].value < 0.0](Source source) {
    const double value = held[source].value;
    return reversing ? -std::abs(value) : value;
  };
  const double turn = car_yaw_rate * car.track_width / 2.0;
  // Of two wheels that roll at an angle of this cosine: of both, or else of the one that is alive.
  const auto of_wheels = [&](Source left, Source right, double along) -> std::optional<AxleSpeed> {
    if (alive(left) && alive(right)) {
      return AxleSpeed{(speed(left) + speed(right)) / 2.0 * along,
                       0.5 * std::hypot(held[left].sigma, held[right].sigma)};
    }
    if (alive(left)) {
      return AxleSpeed{speed(left) * along + turn, held[left].sigma};
    }
    if (alive(right)) {
      return AxleSpeed{speed(right) * along - turn, held[right].sigma};
    }
    return std::nullopt;
  };

  using enum Source;
  const bool both_rear = alive(wheel_rear_left) && alive(wheel_rear_right);
  if (!both_rear && alive(wheel_rear)) {
    return AxleSpeed{speed(wheel_rear), held[wheel_rear].sigma};
  }
  if (const std::optional<AxleSpeed> rear = of_wheels(wheel_rear_left, wheel_rear_right, 1.0)) {
    return rear;
  }
  if (alive(motor)) {
    return AxleSpeed{speed(motor), held[motor].sigma};
  }
  return of_wheels(wheel_front_left, wheel_front_right, std::cos(held[steering].value));
}

}  // namespace odomd::estimator
