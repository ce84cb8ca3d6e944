#include "tools/evaluation/score.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace odomd::tools {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t second_ns = 1'000'000'000;

/// Smaller errors count as equal: their ratio has no meaning.
constexpr double least_error = 1e-9;

}  // namespace

Score score_of(const Evaluation& evaluation) {
  Score score{unknown, unknown, evaluation.position.rms, evaluation.heading.rms};
  if (evaluation.short_term) score[0] = evaluation.short_term->displacement.mean;
  for (const HorizonError& error : evaluation.horizons)
    if (error.horizon_ns == second_ns) score[1] = error.displacement.mean;
  return score;
}

double relative_error(std::span<const Score> tried, std::span<const Score> before) {
  double logarithms = 0.0;
  std::size_t count = 0;
  for (std::size_t drive = 0; drive < before.size(); ++drive) {
    for (std::size_t i = 0; i < before[drive].size(); ++i) {
      if (std::isnan(before[drive][i])) continue;
      if (!std::isfinite(tried[drive][i])) return std::numeric_limits<double>::infinity();
      logarithms += std::log(std::max(tried[drive][i], least_error) /
                             std::max(before[drive][i], least_error));
      ++count;
    }
  }
  return count == 0 ? 1.0 : std::exp(logarithms / static_cast<double>(count));
}

}  // namespace odomd::tools
