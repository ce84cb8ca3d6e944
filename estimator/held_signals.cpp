#include "estimator/held_signals.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/physical_limits.hpp"

namespace odomd::estimator {

HeldSignals::HeldSignals(const std::array<double, source_count>& sigma) noexcept {
  for (std::size_t i = 0; i < source_count; ++i) {
    sigma_[i] = sigma[i] > 0.0 ? sigma[i] : default_sigma[i];
    held_[i].sigma = sigma_[i];
  }
}

Verdict HeldSignals::take(const Measurement& sample, std::int64_t latest_ns) noexcept {
  const auto index = static_cast<std::size_t>(sample.source);
  if (index >= source_count || sample.source == Source::camera) {
    return Verdict::source_off;
  }
  Held& held = held_[index];
  if (!std::isfinite(sample.value) || !std::isfinite(sample.sigma) || sample.sigma < 0.0) {
    return Verdict::non_finite;
  }
  if (sample.time_ns > latest_ns) {
    return Verdict::future;
  }
  if (std::abs(sample.value) > physical_limit[index]) {
    return Verdict::gated;
  }
  if (held.seen && sample.time_ns == held.time_ns) {
    return Verdict::duplicate;
  }
  if (held.seen && sample.time_ns < held.time_ns) {
    return Verdict::too_old;
  }
  const double sigma = sample.sigma > 0.0 ? sample.sigma : sigma_[index];
  held = {true, sample.time_ns, sample.value, std::min(sigma, physical_limit[index])};
  return Verdict::fused;
}

}  // namespace odomd::estimator
