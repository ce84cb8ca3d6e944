#include "tools/tune/tune_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/cli/csv.hpp"
#include "tools/cli/json_text.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

using nlohmann::ordered_json;

/// How the text shows a goal: times a factor, with decimals.
struct Shown {
  std::string_view title;
  double factor = 1.0;
  int decimals = 0;
};
constexpr std::array<Shown, goal_count> shown{{{"position mm", 1e3, 1},
                                               {"heading deg", 180.0 / 3.14159265358979323846, 2},
                                               {"35 ms mm", 1e3, 3},
                                               {"1 s mm", 1e3, 2},
                                               {"end cm/m", 1.0, 2},
                                               {"NEES", 1.0, 2},
                                               {"NIS factor", 1.0, 2}}};

constexpr std::array<std::string_view, 3> fate_names{"taken", "over_fitted", "idle"};

/// "12.3 % better" of 0.877.
std::string in_words(double relative) {
  if (!std::isfinite(relative)) return "no pose";
  const double per_cent = 100.0 * (1.0 - relative);
  return fixed(std::fabs(per_cent), 1) + (per_cent >= 0.0 ? " % better" : " % worse");
}

/// The effect of a key: the errors without it compared with those with it.
std::string effect(double without) {
  if (!std::isfinite(without)) return "needed";
  const double per_cent = 100.0 * (without - 1.0);
  return (per_cent > 0.0 ? "+" : "") + fixed(per_cent, 1) + " %";
}

std::string change(double before, double after, const Shown& how) {
  if (std::isnan(before)) return "-";
  return fixed(before * how.factor, how.decimals) + " > " + fixed(after * how.factor, how.decimals);
}

std::string remark(const TunedKey& key) {
  if (key.fate == Fate::over_fitted) return "over-fitted: value kept";
  if (key.fate == Fate::idle) return "no effect: value kept";
  return key.at_end_of_range ? "at the end of its range: widen it" : "";
}

std::string keys_table(const TuneResult& result) {
  Table table{.header = {"key", "before", "tuned", "helps by"}, .rows = {}};
  const bool held_out = result.held_out_error.has_value();
  if (held_out) table.header.emplace_back("held out");
  table.flush_left = {0, table.header.size()};
  table.header.emplace_back("");
  for (const TunedKey& key : result.keys) {
    std::vector<std::string> row{key.key, key.before ? shortest(*key.before) : "none",
                                 shortest(key.after), effect(key.without)};
    if (held_out) row.push_back(effect(*key.without_held_out));
    row.push_back(remark(key));
    table.rows.push_back(std::move(row));
  }
  return table.text();
}

/// The goals, and always the consistency of the sigmas.
std::vector<Goal> goals_shown(const TuneResult& result) {
  std::vector<Goal> goals = result.goals;
  if (std::ranges::find(goals, Goal::nees) == goals.end()) goals.push_back(Goal::nees);
  return goals;
}

std::string drives_table(const TuneResult& result) {
  Table table{.header = {"drive", ""}, .rows = {}, .flush_left = {0, 1}};
  for (const Goal goal : goals_shown(result))
    table.header.emplace_back(shown[static_cast<std::size_t>(goal)].title);
  table.header.emplace_back("");
  const auto add = [&](const DriveScores& scores, const char* role) {
    std::vector<std::string> row{scores.drive, role};
    for (const Goal goal : goals_shown(result)) {
      const auto i = static_cast<std::size_t>(goal);
      row.push_back(change(scores.before[i], scores.after[i], shown[i]));
    }
    row.push_back(in_words(
        relative_error(std::span(&scores.after, 1), std::span(&scores.before, 1), result.goals)));
    table.rows.push_back(std::move(row));
  };
  for (const DriveScores& scores : result.drives) add(scores, "tuned on");
  for (const DriveScores& scores : result.held_out) add(scores, "held out");
  return table.text();
}

/// "heading (3.1 % worse), nees (2.4 times as far above 3)"
std::string worse_in_words(const TuneResult& result) {
  std::string text;
  for (const GoalChange& change : result.worse) {
    const bool held_out = change.held_out.value_or(0.0) > change.tuned_on;
    const double ratio = held_out ? *change.held_out : change.tuned_on;
    const std::string by = change.goal == Goal::nees && std::isfinite(ratio)
                               ? fixed(ratio, 1) + " times as far above " + fixed(honest_nees, 0)
                               : in_words(ratio);
    text += fmt::format("{}{} ({}{})", text.empty() ? "" : ", ",
                        goal_names[static_cast<std::size_t>(change.goal)], by,
                        held_out ? " on the drives held out" : "");
  }
  return text;
}

std::string verdict(const TuneJob& job, const TuneResult& result) {
  const bool over_fitted = std::ranges::any_of(
      result.keys, [](const TunedKey& key) { return key.fate == Fate::over_fitted; });
  const std::string here = in_words(result.relative_error) + " on the drives tuned on";
  const bool forced = job.worse_goals == WorseGoals::allowed;
  if (result.is_better_here() && !result.worse.empty()) {
    const GoalChange& last = result.worse.back();
    const bool nees_is_new = last.goal == Goal::nees && last.tuned_on > worse_above(Goal::nees) &&
                             std::ranges::find(result.goals, Goal::nees) == result.goals.end();
    const std::string but = here + ", but worse in " + worse_in_words(result);
    if (forced) return but + ": taken by --force.\n";
    return but + ": keep the present configuration" +
           (nees_is_new ? ", add nees to the goals" : "") + ", or take it with --force.\n";
  }
  if (result.is_better() && !result.held_out_error) {
    return here +
           ". Whether this holds on other drives is not known: hold some out with --held-out.\n";
  }
  if (result.is_better())
    return here + ", " + in_words(*result.held_out_error) + " on those held out.\n";
  if (over_fitted)
    return "Without the over-fitted keys nothing is better on the drives tuned on: keep the "
           "present configuration.\n";
  if (result.held_out_error && *result.held_out_error > 1.0)
    return here + ", but " + in_words(*result.held_out_error) + " on those held out: " +
           (forced && result.is_better_here() ? "taken by --force.\n"
                                              : "keep the present configuration.\n");
  return "Nothing better was found.\n";
}

ordered_json json_of(const DriveScores& scores, const char* role) {
  ordered_json json{{"drive", scores.drive}, {"role", role}};
  for (std::size_t i = 0; i < goal_count; ++i)
    json[goal_names[i]] = {{"before", scores.before[i]}, {"after", scores.after[i]}};
  return json;
}

}  // namespace

std::string as_text(const TuneJob& job, const TuneResult& result) {
  std::string text = keys_table(result) + "\n" + drives_table(result) + "\n";
  text += counted(result.trials.size(), "trial");
  if (result.from_state > 0)
    text += fmt::format(", {} known from {}", result.from_state, job.state.string());
  if (result.impossible > 0)
    text += fmt::format(", {} refused (the last: {})", result.impossible, result.why_impossible);
  if (result.cut_short)
    text += fmt::format(
        "; the search was cut short by --trials {}, which leave no whole round: there may be "
        "better",
        job.search.trials);
  return text + ". " + verdict(job, result);
}

std::string as_json(const TuneResult& result) {
  ordered_json json;
  json["goals"] = ordered_json::array();
  for (const Goal goal : result.goals)
    json["goals"].push_back(goal_names[static_cast<std::size_t>(goal)]);
  json["better"] = result.is_better();
  json["worse_goals"] = ordered_json::array();
  for (const GoalChange& change : result.worse)
    json["worse_goals"].push_back(goal_names[static_cast<std::size_t>(change.goal)]);
  json["relative_error"] = result.relative_error;
  json["held_out_relative_error"] =
      result.held_out_error ? ordered_json(*result.held_out_error) : ordered_json();
  json["keys"] = ordered_json::array();
  for (const TunedKey& key : result.keys) {
    json["keys"].push_back(
        {{"key", key.key},
         {"before", key.before ? ordered_json(*key.before) : ordered_json()},
         {"after", key.after},
         {"fate", fate_names[static_cast<std::size_t>(key.fate)]},
         {"without", key.without},
         {"without_held_out",
          key.without_held_out ? ordered_json(*key.without_held_out) : ordered_json()}});
  }
  json["drives"] = ordered_json::array();
  for (const DriveScores& scores : result.drives)
    json["drives"].push_back(json_of(scores, "tuned"));
  for (const DriveScores& scores : result.held_out)
    json["drives"].push_back(json_of(scores, "held_out"));
  json["trials"] = ordered_json::array();
  for (const Trial& trial : result.trials) {
    ordered_json values = ordered_json::array();
    for (const auto& value : trial.values)
      values.push_back(value ? ordered_json(*value) : ordered_json());
    json["trials"].push_back({{"values", values}, {"relative_error", trial.relative_error}});
  }
  json["impossible"] = result.impossible;
  json["cut_short"] = result.cut_short;
  return json_text(json) + "\n";
}

std::string trials_csv(const TuneJob& job, const TuneResult& result) {
  std::string text;
  for (const Parameter& parameter : job.parameters) text += parameter.key + ',';
  text += "relative_error\n";
  for (const Trial& trial : result.trials) {
    for (const auto& value : trial.values) {
      if (value) append_number(text, *value);
      text += ',';
    }
    append_number(text, trial.relative_error);
    text += '\n';
  }
  return text;
}

std::string note_of(const TuneJob& job, const TuneResult& result, const TunedKey& key) {
  std::string note = "odom tune: helps by " + effect(key.without) + "; in all " +
                     in_words(result.relative_error) + " on " + counted(job.drives.size(), "drive");
  if (result.held_out_error)
    note +=
        fmt::format(", {} on {} held out", in_words(*result.held_out_error), job.held_out.size());
  if (!result.worse.empty()) note += ", but worse in " + worse_in_words(result);
  return note;
}

}  // namespace odomd::tools
