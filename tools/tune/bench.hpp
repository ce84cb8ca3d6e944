// The trials of one run of odom tune, and the relative errors that they have.
#pragma once

#include <span>
#include <vector>

#include "tools/tune/trial_log.hpp"
#include "tools/tune/tuning.hpp"

namespace odomd::tools {

/// Runs new trials and keeps their results.
class Bench {
 public:
  /// Replays the unchanged configuration. Both must outlive it. Throws std::invalid_argument for a
  /// state of something else and a goal that no drive determines, Stopped.
  Bench(const TuneJob& job, const TuneWatch& watch);

  /// Relative errors on the drives to tune on.
  [[nodiscard]] std::vector<double> errors(std::span<const Values> wanted);

  /// The same for the steps of a search, which are counted: infinite where they are worse in a goal
  /// and that is refused.
  [[nodiscard]] std::vector<double> costs(std::span<const Values> wanted);

  [[nodiscard]] std::vector<double> held_out_errors(std::span<const Values> wanted);

  /// Fills in what is taken.
  [[nodiscard]] TuneResult finish(const Values& taken);

  /// Of values that were tried.
  [[nodiscard]] bool is_possible(const Values& values) const;

  [[nodiscard]] TuneResult& result() { return result_; }

 private:
  void check_known(const char* which, const std::vector<Score>& scores) const;
  void check_any(const char* which, const std::vector<Score>& scores) const;
  [[nodiscard]] std::vector<GoalChange> worse_goals(const std::vector<Score>& after,
                                                    const std::vector<Score>& held_out) const;
  [[nodiscard]] double error_of(const TrialOutcome& outcome,
                                const std::vector<Score>& before) const;
  std::vector<TrialOutcome> run(const std::vector<Drive>& drives, std::span<const Values> trials,
                                TrialLog* log = nullptr);

  const TuneJob& job_;
  const TuneWatch& watch_;
  TrialLog log_;
  Values as_configured_;
  std::vector<Score> before_;
  std::vector<Score> held_out_before_;
  double best_ = 1.0;
  TuneResult result_;
};

}  // namespace odomd::tools
