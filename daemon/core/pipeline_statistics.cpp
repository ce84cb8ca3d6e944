#include "daemon/core/pipeline_statistics.hpp"

#include <cmath>
#include <cstddef>

namespace odomd::daemon {
namespace {

/// 95 % quantiles of χ² with 1, 2, 3 degrees of freedom.
constexpr std::array<double, 3> chi_squared_95{3.841458820694124, 5.991464547107979,
                                               7.814727903251179};

}  // namespace

void InnovationStatistics::take(const estimator::Judgement& judgement) noexcept {
  if (judgement.degrees < 1 || judgement.degrees > 3) return;
  const auto degrees = static_cast<std::size_t>(judgement.degrees);
  dimension_.set(degrees);
  last_test_ratio_.set(judgement.test_ratio);
  for (std::size_t i = 0; i < degrees; ++i) last_innovation_[i].set(judgement.innovation[i]);
  // A non-finite value would make the sums useless.
  if (!std::isfinite(judgement.squared_ratio)) return;
  nis_sum_.set(nis_sum_.get() + judgement.squared_ratio);
  if (judgement.squared_ratio <= chi_squared_95[degrees - 1]) inside_95_.add();
  if (judgement.verdict == estimator::Verdict::gated) gated_.add();
  count_.add();
}

double InnovationStatistics::mean_nis() const noexcept {
  return count() == 0 ? 0.0 : nis_sum_.get() / static_cast<double>(count());
}

double InnovationStatistics::inside_95() const noexcept {
  return count() == 0 ? 0.0 : static_cast<double>(inside_95_.get()) / static_cast<double>(count());
}

std::array<double, 3> InnovationStatistics::last_innovation() const noexcept {
  return {last_innovation_[0].get(), last_innovation_[1].get(), last_innovation_[2].get()};
}

void NoiseStatistics::set(const estimator::SourceNoise& noise) noexcept {
  stated_.set(noise.stated);
  at_rest_.set(noise.at_rest);
  moving_.set(noise.moving);
  speed_share_.set(noise.speed_share);
}

estimator::SourceNoise NoiseStatistics::get() const noexcept {
  return {stated_.get(), at_rest_.get(), moving_.get(), speed_share_.get()};
}

std::uint64_t SourceStatistics::judged() const noexcept {
  std::uint64_t sum = 0;
  for (const Counter& verdict : verdicts) sum += verdict.get();
  return sum;
}

}  // namespace odomd::daemon
