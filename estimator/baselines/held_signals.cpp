#include "estimator/baselines/held_signals.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/common/admission.hpp"

namespace odomd::estimator {

HeldSignals::HeldSignals(const std::array<double, source_count>& sigma) noexcept {
  for (std::size_t i = 0; i < source_count; ++i) {
    sigma_[i] = sigma[i] > 0.0 ? sigma[i] : default_sigma[i];
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
  Held& held = held_[index];
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
