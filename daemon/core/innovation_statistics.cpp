#include "daemon/core/innovation_statistics.hpp"

#include <bit>
#include <cmath>
#include <cstddef>

namespace odomd::daemon {
namespace {

/// 95 % quantiles of χ² with 1, 2, 3 degrees of freedom.
constexpr std::array<double, 3> chi_squared_95{3.841458820694124, 5.991464547107979,
                                               7.814727903251179};

double real(const Counter& bits) noexcept {
  return std::bit_cast<double>(bits.get());
}

void set(Counter& bits, double value) noexcept {
  bits.set(std::bit_cast<std::uint64_t>(value));
}

}  // namespace

void InnovationStatistics::take(const estimator::Judgement& judgement) noexcept {
  if (judgement.degrees < 1 || judgement.degrees > 3) return;
  const auto degrees = static_cast<std::size_t>(judgement.degrees);
  dimension_.set(degrees);
  set(last_test_ratio_, judgement.test_ratio);
  for (std::size_t i = 0; i < degrees; ++i) set(last_innovation_[i], judgement.innovation[i]);
  // A non-finite value would make the sums useless.
  if (!std::isfinite(judgement.squared_ratio)) return;
  set(nis_sum_, real(nis_sum_) + judgement.squared_ratio);
  if (judgement.squared_ratio <= chi_squared_95[degrees - 1]) inside_95_.add();
  if (judgement.verdict == estimator::Verdict::gated) gated_.add();
  count_.add();
}

double InnovationStatistics::mean_nis() const noexcept {
  return count() == 0 ? 0.0 : real(nis_sum_) / static_cast<double>(count());
}

double InnovationStatistics::inside_95() const noexcept {
  return count() == 0 ? 0.0 : static_cast<double>(inside_95_.get()) / static_cast<double>(count());
}

double InnovationStatistics::last_test_ratio() const noexcept {
  return real(last_test_ratio_);
}

std::array<double, 3> InnovationStatistics::last_innovation() const noexcept {
  return {real(last_innovation_[0]), real(last_innovation_[1]), real(last_innovation_[2])};
}

}  // namespace odomd::daemon
