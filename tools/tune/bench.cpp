#include "tools/tune/bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace odomd::tools {
namespace {

std::vector<std::string> names_of(const TuneJob& job) {
  std::vector<std::string> names;
  for (const Drive& drive : job.drives) names.push_back(drive.name);
  return names;
}

bool is_known(Goal goal, const std::vector<Score>& scores) {
  return std::ranges::any_of(scores, [index = static_cast<std::size_t>(goal)](const Score& score) {
    return !std::isnan(score[index]);
  });
}

std::vector<DriveScores> scores_of(const std::vector<Drive>& drives,
                                   const std::vector<Score>& before,
                                   const std::vector<Score>& after) {
  std::vector<DriveScores> scores;
  for (std::size_t i = 0; i < drives.size(); ++i)
    scores.push_back({drives[i].name, before[i], after[i]});
  return scores;
}

}  // namespace

Bench::Bench(const TuneJob& job, const TuneWatch& watch)
    : job_(job),
      watch_(watch),
      log_(job.state, job.parameters, names_of(job)),
      as_configured_(job.parameters.size()) {
  const TrialOutcome before = run(job_.drives, std::span(&as_configured_, 1)).front();
  log_.check_unchanged(as_configured_, before);
  if (log_.find(as_configured_) == nullptr) log_.add(as_configured_, before);
  before_ = before.scores;
  check_known("tuned on", before_);
  result_.goals = job.goals;
  for (const Goal goal : job.goals_if_known)
    if (is_known(goal, before_)) result_.goals.push_back(goal);
  for (const Goal goal : job.goals_else)
    if (result_.goals.empty() && is_known(goal, before_)) result_.goals.push_back(goal);
  check_any("tuned on", before_);
  if (!job.held_out.empty()) {
    held_out_before_ = run(job_.held_out, std::span(&as_configured_, 1)).front().scores;
    check_known("held out", held_out_before_);
    check_any("held out", held_out_before_);
  }
  result_.from_state = log_.read();
}

std::vector<double> Bench::errors(std::span<const Values> wanted) {
  std::vector<Values> missing;
  for (const Values& values : wanted)
    if (log_.find(values) == nullptr && std::ranges::find(missing, values) == missing.end())
      missing.push_back(values);
  (void)run(job_.drives, missing, &log_);

  std::vector<double> errors;
  for (const Values& values : wanted) {
    const TrialOutcome& outcome = *log_.find(values);
    errors.push_back(error_of(outcome, before_));
  }
  return errors;
}

std::vector<double> Bench::costs(std::span<const Values> wanted) {
  std::vector<double> costs = errors(wanted);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const TrialOutcome& outcome = *log_.find(wanted[i]);
    result_.trials.push_back({wanted[i], costs[i]});
    if (!outcome.impossible.empty()) {
      ++result_.impossible;
      result_.why_impossible = outcome.impossible;
    }
    if (job_.worse_goals == WorseGoals::refused && outcome.impossible.empty() &&
        !worse_goals(outcome.scores, {}).empty())
      costs[i] = std::numeric_limits<double>::infinity();
    best_ = std::min(best_, costs[i]);
  }
  return costs;
}

std::vector<double> Bench::held_out_errors(std::span<const Values> wanted) {
  std::vector<double> errors;
  for (const TrialOutcome& outcome : run(job_.held_out, wanted))
    errors.push_back(error_of(outcome, held_out_before_));
  return errors;
}

TuneResult Bench::finish(const Values& taken) {
  result_.relative_error = errors(std::span(&taken, 1)).front();
  const std::vector<Score>& after = log_.find(taken)->scores;
  result_.drives = scores_of(job_.drives, before_, after);
  TrialOutcome held_out;
  if (!job_.held_out.empty()) {
    held_out = run(job_.held_out, std::span(&taken, 1)).front();
    result_.held_out_error = error_of(held_out, held_out_before_);
    result_.held_out = scores_of(job_.held_out, held_out_before_, held_out.scores);
  }
  result_.worse = worse_goals(after, held_out.scores);
  return std::move(result_);
}

bool Bench::is_possible(const Values& values) const {
  return log_.find(values)->impossible.empty();
}

// Any setting would improve a goal that no drive determines.
void Bench::check_known(const char* which, const std::vector<Score>& scores) const {
  for (const Goal goal : job_.goals)
    if (!is_known(goal, scores))
      throw std::invalid_argument(fmt::format("--goal {}: none of the drives {} determines it: {}",
                                              goal_names[static_cast<std::size_t>(goal)], which,
                                              why_unknown(goal)));
}

void Bench::check_any(const char* which, const std::vector<Score>& scores) const {
  if (std::ranges::any_of(result_.goals, [&](Goal goal) { return is_known(goal, scores); })) return;
  throw std::invalid_argument(fmt::format(
      "none of the drives {} determines a goal of the search: they have neither "
      "truth.csv nor camera.csv, and no closed loop; give drives that have one, or tune "
      "the innovations with --goal nis --model full",
      which));
}

std::vector<GoalChange> Bench::worse_goals(const std::vector<Score>& after,
                                           const std::vector<Score>& held_out) const {
  // Sigmas that are no longer honest are worse whatever the goals are.
  std::vector<Goal> goals = result_.goals;
  if (std::ranges::find(goals, Goal::nees) == goals.end()) goals.push_back(Goal::nees);
  std::vector<GoalChange> worse;
  for (const Goal goal : goals) {
    GoalChange change{.goal = goal, .tuned_on = judged_error(after, before_, goal)};
    if (!held_out.empty()) change.held_out = judged_error(held_out, held_out_before_, goal);
    if (std::max(change.tuned_on, change.held_out.value_or(1.0)) > worse_above(goal))
      worse.push_back(change);
  }
  return worse;
}

double Bench::error_of(const TrialOutcome& outcome, const std::vector<Score>& before) const {
  return outcome.impossible.empty() ? relative_error(outcome.scores, before, result_.goals)
                                    : std::numeric_limits<double>::infinity();
}

std::vector<TrialOutcome> Bench::run(const std::vector<Drive>& drives,
                                     std::span<const Values> trials, TrialLog* log) {
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

}  // namespace odomd::tools
