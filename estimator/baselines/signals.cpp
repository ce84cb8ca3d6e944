#include "estimator/baselines/signals.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/time.hpp"
#include "estimator/common/vehicle.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator {

HeldSignals::HeldSignals(const FilterSettings& settings) noexcept : sigma_(settings.sigma) {
  for (std::size_t i = 0; i < source_count; ++i) {
    held_[i].sigma = sigma_[i];
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
  if (is_wheel(sample.source)) {
    newest_wheel_ns_ = std::max(newest_wheel_ns_, sample.time_ns);
  }
  return Verdict::fused;
}

bool HeldSignals::alive(Source wheel) const noexcept {
  constexpr double silent_after_s = 0.5;
  const HeldSignal& held = (*this)[wheel];
  return held.seen && seconds_between(held.time_ns, newest_wheel_ns_) <= silent_after_s;
}

bool HeldSignals::wheels_still() const noexcept {
  bool any = false;
  for (const Source wheel : wheel_sources) {
    const HeldSignal& held = (*this)[wheel];
    if (alive(wheel) && is_turning(held.value, held.sigma)) {
      return false;
    }
    any |= alive(wheel);
  }
  return any;
}

std::optional<AxleSpeed> rear_axle_speed(const Vehicle& car, const HeldSignals& held,
                                         double car_yaw_rate) noexcept {
  const auto speed = [&, reversing = held[Source::direction].value < 0.0](Source source) {
    const double value = held[source].value;
    return reversing ? -std::abs(value) : value;
  };

  // v_x at the middle of an axle, from both its wheels or from one: v cos(angle) ± ψ̇ t/2, with t
  // the track width; a front wheel rolls along δ.
  using enum Source;
  const double turn = car_yaw_rate * car.track_width / 2.0;
  const double front = std::cos(held[steering].value);
  struct Choice {
    Source left, right;  // equal for a single wheel
    double along, turn;
  };
  for (const Choice& of : {Choice{wheel_rear_left, wheel_rear_right, 1.0, 0.0},
                           {wheel_rear, wheel_rear, 1.0, 0.0},
                           {wheel_rear_left, wheel_rear_left, 1.0, turn},
                           {wheel_rear_right, wheel_rear_right, 1.0, -turn},
                           {motor, motor, 1.0, 0.0},
                           {wheel_front_left, wheel_front_right, front, 0.0},
                           {wheel_front_left, wheel_front_left, front, turn},
                           {wheel_front_right, wheel_front_right, front, -turn}}) {
    if (held.alive(of.left) && held.alive(of.right)) {
      const double sigma = of.left == of.right
                               ? held[of.left].sigma
                               : 0.5 * std::hypot(held[of.left].sigma, held[of.right].sigma);
      return AxleSpeed{(speed(of.left) + speed(of.right)) / 2.0 * of.along + of.turn, sigma};
    }
  }
  return std::nullopt;
}

}  // namespace odomd::estimator
