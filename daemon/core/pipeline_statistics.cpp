#include "daemon/core/pipeline_statistics.hpp"

#include <algorithm>
#include <cmath>

namespace odomd::daemon {
namespace {

/// 95 % quantiles of χ² with 1, 2, 3 degrees of freedom.
constexpr std::array<double, 3> chi_squared_95{3.841458820694124, 5.991464547107979,
                                               7.814727903251179};

}  // namespace

void InnovationStatistics::take(const estimator::Judgement& judgement) noexcept {
  if (judgement.degrees < 1 || judgement.degrees > 3) return;
  dimension = static_cast<std::uint64_t>(judgement.degrees);
  test_ratio = judgement.test_ratio;
  std::copy_n(judgement.innovation.begin(), dimension, innovation.begin());
  // A non-finite value would make the sum useless.
  if (!std::isfinite(judgement.squared_ratio)) return;
  nis_sum += judgement.squared_ratio;
  if (judgement.squared_ratio <= chi_squared_95[dimension - 1]) ++below_95;
  if (judgement.verdict == estimator::Verdict::gated) ++gated;
  ++count;
}

double InnovationStatistics::mean_nis() const noexcept {
  return count == 0 ? 0.0 : nis_sum / static_cast<double>(count);
}

double InnovationStatistics::inside_95() const noexcept {
  return count == 0 ? 0.0 : static_cast<double>(below_95) / static_cast<double>(count);
}

std::uint64_t SourceStatistics::judged() const noexcept {
  std::uint64_t sum = 0;
  for (const Counter& verdict : verdicts) sum += verdict.get();
  return sum;
}

}  // namespace odomd::daemon
