#include "tools/tune/tuning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tools/config_patch/config_patch.hpp"
#include "tools/tune/bench.hpp"
#include "tools/tune/value_in_force.hpp"

namespace odomd::tools {
namespace {

constexpr std::size_t most_combinations = 100'000;

/// Insignificant ratios: half a per cent.
constexpr double indifferent = 0.005;

/// A key with a smaller effect is not changed.
constexpr double idle = 0.001;

bool is_swept(const Parameter& parameter) {
  return !parameter.values.empty();
}

/// The first drive's.
std::optional<double> number_in_force(const TuneJob& job, const std::string& key) {
  const daemon::Config& config = job.drives.front().config;
  const std::optional<double> written = number_in(config.text, config.file, key);
  return written ? written : value_in_force(config, key);
}

Values values_at(const TuneJob& job, const Point& point) {
  Values values;
  for (std::size_t i = 0; i < point.size(); ++i)
    values.emplace_back(value_at(job.parameters[i], point[i]));
  return values;
}

Values searched(const TuneJob& job, Bench& bench) {
  Point start;
  for (const Parameter& parameter : job.parameters) {
    const std::optional<double> value = number_in_force(job, parameter.key);
    start.push_back(value ? place_of(parameter, *value) : 0.5);
  }
  const Costs costs = [&](std::span<const Point> points) {
    std::vector<Values> wanted;
    for (const Point& point : points) wanted.push_back(values_at(job, point));
    return bench.costs(wanted);
  };
  const Found found = compass_search(costs, std::move(start), job.search);
  bench.result().cut_short = found.cut_short;
  return values_at(job, found.point);
}

Values swept(const TuneJob& job, Bench& bench) {
  std::vector<Values> combinations{Values{}};
  for (const Parameter& parameter : job.parameters) {
    std::vector<Values> longer;
    for (const Values& shorter : combinations) {
      for (const double value : parameter.values) {
        longer.push_back(shorter);
        longer.back().emplace_back(value);
      }
    }
    combinations = std::move(longer);
    if (combinations.size() > most_combinations)
      throw std::invalid_argument(
          fmt::format("--set: more than {} combinations; give fewer values, or ranges to search",
                      most_combinations));
  }
  std::vector<double> costs = bench.costs(combinations);
  if (std::ranges::none_of(costs, [](double cost) { return std::isfinite(cost); }))
    costs = bench.errors(combinations);  // to say in which goal they are worse
  return combinations[static_cast<std::size_t>(std::ranges::min_element(costs) - costs.begin())];
}

double ratio(double without, double with) {
  return std::isfinite(without) && with > 0.0 ? without / with
                                              : std::numeric_limits<double>::infinity();
}

TunedKey judged(const TuneJob& job, std::size_t index, double value, double without,
                std::optional<double> without_held_out) {
  const Parameter& parameter = job.parameters[index];
  TunedKey key{.key = parameter.key,
               .before = number_in_force(job, parameter.key),
               .after = value,
               .at_end_of_range = value == parameter.from || value == parameter.to,
               .without = without,
               .without_held_out = without_held_out};
  key.fate = fate_of(without, without_held_out);
  return key;
}

/// The effect of each key, by trials without it. Keys that harm the held-out drives, and those
/// without effect, keep their value.
Values what_to_take(const TuneJob& job, Bench& bench, const Values& best) {
  std::vector<Values> tried{best};
  for (std::size_t i = 0; i < best.size(); ++i) {
    tried.push_back(best);
    tried.back()[i].reset();
  }
  const std::vector<double> errors = bench.errors(tried);
  std::vector<double> held_out;
  if (!job.held_out.empty()) held_out = bench.held_out_errors(tried);

  Values helpful = best;
  Values needed = best;
  for (std::size_t i = 0; i < best.size(); ++i) {
    std::optional<double> without_held_out;
    if (!held_out.empty()) without_held_out = ratio(held_out[i + 1], held_out[0]);
    TunedKey key = judged(job, i, *best[i], ratio(errors[i + 1], errors[0]), without_held_out);
    if (key.fate == Fate::over_fitted) helpful[i].reset();
    if (key.fate != Fate::taken) needed[i].reset();
    bench.result().keys.push_back(std::move(key));
  }
  // Of two keys with the same effect each looks idle while the other is there.
  const std::array both{helpful, needed};
  const std::vector<double> compared = bench.errors(both);
  if (compared[1] <= compared[0] * (1.0 + indifferent)) return needed;
  for (TunedKey& key : bench.result().keys)
    if (key.fate == Fate::idle) key.fate = Fate::taken;
  return helpful;
}

}  // namespace

Fate fate_of(double without, std::optional<double> without_held_out) {
  if (without_held_out && *without_held_out < 1.0 - indifferent) return Fate::over_fitted;
  const bool helps = without > 1.0 + idle || without_held_out.value_or(1.0) > 1.0 + idle;
  return helps ? Fate::taken : Fate::idle;
}

bool TuneResult::is_better_here() const {
  return relative_error < 1.0 - indifferent;
}

bool TuneResult::is_better() const {
  return is_better_here() && (!held_out_error || *held_out_error <= 1.0 + indifferent) &&
         worse.empty();
}

TuneResult tune(const TuneJob& job, const TuneWatch& watch) {
  const auto swept_count = std::ranges::count_if(job.parameters, is_swept);
  const bool sweep = swept_count > 0;
  if (sweep && static_cast<std::size_t>(swept_count) != job.parameters.size())
    throw std::invalid_argument(
        "--set: some keys have a range to search and some have values; give ranges for all or "
        "values for all");
  Bench bench(job, watch);
  const Values best = sweep ? swept(job, bench) : searched(job, bench);
  if (!bench.is_possible(best)) throw std::invalid_argument(bench.result().why_impossible);
  return bench.finish(what_to_take(job, bench, best));
}

}  // namespace odomd::tools
