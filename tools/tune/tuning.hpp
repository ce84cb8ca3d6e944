// Searches for better settings on some drives and validates them on others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/tune/search.hpp"
#include "tools/tune/trials.hpp"

namespace odomd::tools {

/// Whether the search may take settings that are worse in a goal, or in nees where it is none.
enum class WorseGoals : std::uint8_t { refused, allowed };

struct TuneJob {
  std::vector<Drive> drives;    ///< to tune on; at least one
  std::vector<Drive> held_out;  ///< to validate on, not used by the search
  std::vector<Parameter> parameters;
  std::vector<Goal> goals;
  std::vector<Goal> goals_if_known;  ///< goals too, where a drive to tune on determines them
  std::vector<Goal> goals_else;      ///< without any of these: the first that is determined
  WorseGoals worse_goals = WorseGoals::refused;
  std::optional<estimator::Model> model;
  Measure measure;
  std::size_t threads = 1;
  SearchSettings search;
  std::filesystem::path state;  ///< empty: none
};

/// What became of a key.
enum class Fate : std::uint8_t {
  taken,        ///< its value is the tuned one
  over_fitted,  ///< harms the held-out drives: value kept
  idle,         ///< no effect: value kept
};

/// By TunedKey::without, without_held_out.
[[nodiscard]] Fate fate_of(double without, std::optional<double> without_held_out);

struct TunedKey {
  std::string key;
  std::optional<double> before;  ///< in force with the first drive's configuration; nothing: none
  double after = 0.0;            ///< as found, whatever its fate
  bool at_end_of_range = false;
  Fate fate = Fate::taken;
  // Relative errors with this key alone put back, over those of all tuned: above 1, it helps.
  double without = 1.0;
  std::optional<double> without_held_out;
};

struct DriveScores {
  std::string drive;
  Score before{};
  Score after{};
};

/// A goal's judged_error().
struct GoalChange {
  Goal goal = Goal::position;
  double tuned_on = 1.0;
  std::optional<double> held_out;
};

struct Trial {
  Values values;
  double relative_error = 1.0;
};

struct TuneResult {
  std::vector<Goal> goals;  ///< that were tuned for
  std::vector<TunedKey> keys;
  double relative_error = 1.0;           ///< of what is taken, on the drives tuned on
  std::optional<double> held_out_error;  ///< and on the others
  std::vector<DriveScores> drives;
  std::vector<DriveScores> held_out;
  std::vector<GoalChange> worse;  ///< goals that have become worse, and nees, goal or not
  std::vector<Trial> trials;      ///< all, in the order of the search
  std::size_t impossible = 0;     ///< of them, refused by the configuration
  std::string why_impossible;     ///< the last of these
  bool cut_short = false;         ///< the search, by SearchSettings::trials
  std::size_t from_state = 0;     ///< read from the state, not tried again

  /// Whether the mean over the goals is better on the drives tuned on.
  [[nodiscard]] bool is_better_here() const;
  /// Whether to take the settings: better there, not worse on those held out, and in no goal.
  [[nodiscard]] bool is_better() const;
};

/// Reported now and then: replays done in this round, trials so far, the least relative error.
struct TuneProgress {
  std::size_t done = 0;
  std::size_t all = 0;
  std::size_t trials = 0;
  double best = 1.0;
};
using TuneWatch = std::function<GoOn(const TuneProgress&)>;

/// Searches ranges by compass_search, or tries every combination of values. The same job has the
/// same result, whatever the number of threads and however often it was stopped and continued.
/// Throws std::invalid_argument for a job that cannot be done, Stopped.
[[nodiscard]] TuneResult tune(const TuneJob& job, const TuneWatch& watch);

}  // namespace odomd::tools
