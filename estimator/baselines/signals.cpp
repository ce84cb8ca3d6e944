#include "estimator/baselines/signals.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/common/time.hpp"
#include "estimator/common/wheel_place.hpp"
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
  // The mean of an axle's wheels, each moved to its middle: v_x = v cos(angle) + y ψ̇, a front wheel
  // rolls along δ.
  using enum Source;
  const bool reversing = held[direction].value < 0.0;
  for (const auto& [left, right] : {std::pair{wheel_rear_left, wheel_rear_right},
                                    {wheel_rear, wheel_rear},
                                    {motor, motor},
                                    {wheel_front_left, wheel_front_right}}) {
    AxleSpeed axle;
    double wheels = 0.0;
    for (const Source wheel : {left, right}) {
      if (held.alive(wheel) && (left != right || wheels == 0.0)) {
        const WheelPlace place = wheel_place(car, wheel);
        const double value = reversing ? -std::abs(held[wheel].value) : held[wheel].value;
        const double along = place.steered ? std::cos(held[steering].value) : 1.0;
        axle.v_x += value * along + place.left * car_yaw_rate;
        axle.sigma = std::hypot(axle.sigma, held[wheel].sigma);
        ++wheels;
      }
    }
    if (wheels > 0.0) {
      return AxleSpeed{axle.v_x / wheels, axle.sigma / wheels};
    }
  }
  return std::nullopt;
}

}  // namespace odomd::estimator
