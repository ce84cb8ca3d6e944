#include "tools/tune/tuning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tools/config_patch/config_patch.hpp"
#include "tools/tune/trial_log.hpp"
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

/// Runs new trials and keeps their results.
class Bench {
 public:
  Bench(const TuneJob& job, const TuneWatch& watch)
      : job_(job),
        watch_(watch),
        log_(job.state, job.parameters, names_of(job)),
        as_configured_(job.parameters.size()) {
    const TrialOutcome before = run(job_.drives, std::span(&as_configured_, 1)).front();
    log_.check_unchanged(as_configured_, before);
    if (log_.find(as_configured_) == nullptr) log_.add(as_configured_, before);
    before_ = before.scores;
    check_known("tuned on", before_);
    if (!job.held_out.empty()) {
      held_out_before_ = run(job_.held_out, std::span(&as_configured_, 1)).front().scores;
      check_known("held out", held_out_before_);
    }
    result_.from_state = log_.read();
  }

  /// Relative errors on the drives to tune on, each trial counted.
  std::vector<double> errors(std::span<const Values> wanted) {
    std::vector<Values> missing;
    for (const Values& values : wanted)
      if (log_.find(values) == nullptr && std::ranges::find(missing, values) == missing.end())
        missing.push_back(values);
    (void)run(job_.drives, missing, &log_);

    std::vector<double> errors;
    for (const Values& values : wanted) {
      const TrialOutcome& outcome = *log_.find(values);
      errors.push_back(error_of(outcome, before_));
      result_.trials.push_back({values, errors.back()});
      if (!outcome.impossible.empty()) {
        ++result_.impossible;
        result_.why_impossible = outcome.impossible;
      }
      best_ = std::min(best_, errors.back());
    }
    return errors;
  }

  /// Trials that examine a result and are not steps of the search.
  std::vector<double> uncounted_errors(std::span<const Values> wanted) {
    const std::size_t counted = result_.trials.size();
    std::vector<double> found = errors(wanted);
    result_.trials.resize(counted);
    return found;
  }

  std::vector<double> held_out_errors(std::span<const Values> wanted) {
    std::vector<double> errors;
    for (const TrialOutcome& outcome : run(job_.held_out, wanted))
      errors.push_back(error_of(outcome, held_out_before_));
    return errors;
  }

  /// Fills in what is taken.
  TuneResult finish(const Values& taken) {
    result_.relative_error = uncounted_errors(std::span(&taken, 1)).front();
    result_.drives = scores_of(job_.drives, before_, log_.find(taken)->scores);
    if (!job_.held_out.empty()) {
      const TrialOutcome after = run(job_.held_out, std::span(&taken, 1)).front();
      result_.held_out_error = error_of(after, held_out_before_);
      result_.held_out = scores_of(job_.held_out, held_out_before_, after.scores);
    }
    return std::move(result_);
  }

  /// Of values that were tried.
  [[nodiscard]] bool is_possible(const Values& values) const {
    return log_.find(values)->impossible.empty();
  }
  TuneResult& result() { return result_; }

 private:
  static std::vector<std::string> names_of(const TuneJob& job) {
    std::vector<std::string> names;
    for (const Drive& drive : job.drives) names.push_back(drive.name);
    return names;
  }

  // Any setting would improve a goal that no drive determines.
  void check_known(const char* which, const std::vector<Score>& scores) const {
    for (const Goal goal : job_.goals) {
      const auto index = static_cast<std::size_t>(goal);
      const auto is_known = [index](const Score& score) { return !std::isnan(score[index]); };
      if (std::ranges::none_of(scores, is_known))
        throw std::invalid_argument(
            fmt::format("--goal {}: none of the drives {} determines it: {}", goal_names[index],
                        which, why_unknown(goal)));
    }
  }

  [[nodiscard]] double error_of(const TrialOutcome& outcome,
                                const std::vector<Score>& before) const {
    return outcome.impossible.empty() ? relative_error(outcome.scores, before, job_.goals)
                                      : std::numeric_limits<double>::infinity();
  }

  static std::vector<DriveScores> scores_of(const std::vector<Drive>& drives,
                                            const std::vector<Score>& before,
                                            const std::vector<Score>& after) {
    std::vector<DriveScores> scores;
    for (std::size_t i = 0; i < drives.size(); ++i)
      scores.push_back({drives[i].name, before[i], after[i]});
    return scores;
  }

  std::vector<TrialOutcome> run(const std::vector<Drive>& drives, std::span<const Values> trials,
                                TrialLog* log = nullptr) {
    if (trials.empty()) return {};
    const TrialSettings settings{.drives = drives,
                                 .parameters = job_.parameters,
                                 .model = job_.model,
                                 .measure = job_.measure,
                                 .threads = job_.threads};
    return run_trials(
        settings, trials,
        [&](std::size_t done, std::size_t all) {
          return watch_({.done = done, .all = all, .trials = result_.trials.size(), .best = best_});
        },
        [&](std::size_t trial, const TrialOutcome& outcome) {
          if (log != nullptr) log->add(trials[trial], outcome);
        });
  }

  const TuneJob& job_;
  const TuneWatch& watch_;
  TrialLog log_;
  Values as_configured_;
  std::vector<Score> before_;
  std::vector<Score> held_out_before_;
  double best_ = 1.0;
  TuneResult result_;
};

Values values_at(const TuneJob& job, const Point& point) {
  Values values;
  for (std::size_t i = 0; i < point.size(); ++i)
    values.emplace_back(value_at(job.parameters[i], point[i]));
  return values;
}

Values searched(const TuneJob& job, Bench& bench) {
  Point start;
  const daemon::Config& config = job.drives.front().config;
  for (const Parameter& parameter : job.parameters) {
    std::optional<double> value = number_in(config.text, config.file, parameter.key);
    if (!value) value = value_in_force(config, parameter.key);
    start.push_back(value ? place_of(parameter, *value) : 0.5);
  }
  const Costs costs = [&](std::span<const Point> points) {
    std::vector<Values> wanted;
    for (const Point& point : points) wanted.push_back(values_at(job, point));
    return bench.errors(wanted);
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
  const std::vector<double> errors = bench.errors(combinations);
  return combinations[static_cast<std::size_t>(std::ranges::min_element(errors) - errors.begin())];
}

double ratio(double without, double with) {
  return std::isfinite(without) && with > 0.0 ? without / with
                                              : std::numeric_limits<double>::infinity();
}

TunedKey judged(const TuneJob& job, std::size_t index, double value, double without,
                std::optional<double> without_held_out) {
  const Parameter& parameter = job.parameters[index];
  const daemon::Config& config = job.drives.front().config;
  TunedKey key{.key = parameter.key,
               .before = number_in(config.text, config.file, parameter.key),
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
  const std::vector<double> errors = bench.uncounted_errors(tried);
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
  const std::vector<double> compared = bench.uncounted_errors(both);
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

bool TuneResult::is_better() const {
  return relative_error < 1.0 - indifferent &&
         (!held_out_error || *held_out_error <= 1.0 + indifferent);
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
