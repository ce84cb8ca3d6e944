#include "tools/tune/score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace odomd::tools {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t second_ns = 1'000'000'000;

/// Smaller errors count as equal: their ratio has no meaning.
constexpr double least_error = 1e-9;

/// The objective for a score.
double error_of(const Score& score, Goal goal) {
  const double value = score[static_cast<std::size_t>(goal)];
  const double error =
      goal == Goal::nees ? std::exp(std::fabs(std::log(value / honest_nees))) : value;
  return std::isnan(error) ? error : std::max(error, least_error);
}

}  // namespace

std::string why_unknown(Goal goal) {
  switch (goal) {
    case Goal::prediction:
      return "they are shorter than 35 ms, or have no truth.csv: a camera's noise hides it; use "
             "longer drives with truth.csv, or the goal second";
    case Goal::second:
      return "they are shorter than a second, or have neither truth.csv nor camera.csv; use longer "
             "ones with one of them";
    case Goal::end:
      return "the car does not move, or they have neither truth.csv nor camera.csv and do not end "
             "where they began; use other drives, or the goal nis";
    case Goal::nis:
      return "the model does not test its samples; use --model full";
    case Goal::nees:
      return "the covariance matches the errors only in a map with camera poses without alignment, "
             "or if the uncertainty at the start is small compared with that at the end; use such "
             "drives, or other goals";
    default:
      return "they have neither truth.csv nor camera.csv; record camera poses, or use the goals "
             "end "
             "(of a closed loop) or nis";
  }
}

Score score_of(const Evaluation& evaluation) {
  Score score;
  score.fill(unknown);
  const auto set = [&](Goal goal, double value) { score[static_cast<std::size_t>(goal)] = value; };
  if (evaluation.nis_factor) set(Goal::nis, *evaluation.nis_factor);
  if (has_reference(evaluation.against)) {
    set(Goal::position, evaluation.position.rms);
    set(Goal::heading, evaluation.heading.rms);
  }
  if (evaluation.short_term) set(Goal::prediction, evaluation.short_term->displacement.mean);
  for (const HorizonError& error : evaluation.horizons)
    if (error.horizon_ns == second_ns) set(Goal::second, error.displacement.mean);
  if (evaluation.end_cm_per_m) set(Goal::end, *evaluation.end_cm_per_m);
  if (evaluation.consistency && evaluation.consistency->nees > 0.0)
    set(Goal::nees, evaluation.consistency->nees);
  return score;
}

double relative_error(std::span<const Score> tried, std::span<const Score> before,
                      std::span<const Goal> goals) {
  double logarithms = 0.0;
  std::size_t count = 0;
  for (std::size_t drive = 0; drive < before.size(); ++drive) {
    for (const Goal goal : goals) {
      const double then = error_of(before[drive], goal);
      if (std::isnan(then)) continue;
      const double now = error_of(tried[drive], goal);
      if (!std::isfinite(now)) return std::numeric_limits<double>::infinity();
      logarithms += std::log(now / then);
      ++count;
    }
  }
  return count == 0 ? 1.0 : std::exp(logarithms / static_cast<double>(count));
}

double judged_error(std::span<const Score> tried, std::span<const Score> before, Goal goal) {
  const auto judged = [](std::span<const Score> scores) {
    std::vector<Score> result(scores.begin(), scores.end());
    for (Score& score : result) {
      double& nees = score[static_cast<std::size_t>(Goal::nees)];
      nees = std::max(nees, honest_nees);  // NaN stays
    }
    return result;
  };
  return relative_error(judged(tried), judged(before), std::span(&goal, 1));
}

}  // namespace odomd::tools
