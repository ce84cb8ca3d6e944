#include "tools/init/proposal.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <ranges>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "can_protocol/decode/units.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;
using Rhythms = std::map<std::uint32_t, Rhythm>;

std::uint32_t key_of(const Candidate& candidate) {
  return can::frame_key(candidate.message->id, candidate.message->format);
}

bool changes(const Series& series) {
  const auto [min, max] = std::ranges::minmax_element(series.value);
  return !series.empty() && *max > *min;
}

/// A candidate whose score is lower by less than this is an alternative.
constexpr double close_score = 1.5;

/// Whether two signals correlate.
bool are_correlated(const Series& one, const Series& other) {
  constexpr double min_correlation = 0.9;
  const std::vector<Resampled> both = on_one_grid({&one, &other});
  if (both.empty()) return false;
  const auto values = [&](std::size_t i) {
    return Eigen::Map<const Eigen::ArrayXd>(both[i].value.data(), std::ssize(both[i].value));
  };
  return std::fabs(relation_of(values(0), values(1)).correlation) >= min_correlation;
}

Choice best_of(std::vector<Choice> choices, bool has_log) {
  // A signal that never changes ranks below those that do.
  std::ranges::stable_sort(choices, std::ranges::greater{}, [&](const Choice& choice) {
    return choice.candidate.score - (has_log && !changes(choice.series) ? 2.0 * close_score : 0.0);
  });
  Choice choice = std::move(choices.front());
  choice.warnings = choice.candidate.warnings;
  for (const Choice& other : std::views::drop(choices, 1)) {
    if (choice.candidate.score - other.candidate.score >= close_score) continue;
    if (has_log && !changes(other.series) && changes(choice.series)) continue;
    if (has_log && are_correlated(choice.series, other.series))
      choice.reasons.push_back(fmt::format("{} agrees with it", other.candidate.name()));
    else
      choice.warnings.push_back(fmt::format("{} is possible as well", other.candidate.name()));
  }
  return choice;
}

/// Sets time-out and bus according to the traffic.
void apply_rhythm(Choice& choice, const Rhythm& rhythm) {
  constexpr double default_timeout = 0.1, cycles = 5.0, resolution = 0.01;  // s
  const double given = 3e-9 * static_cast<double>(choice.candidate.message->cycle_time_ns);
  const double usual = given > 0.0 ? given : default_timeout;
  const double needed = std::max(cycles * rhythm.cycle, 1.5 * rhythm.longest);
  choice.reasons.push_back(fmt::format("every {:.4g} ms in the log", 1e3 * rhythm.cycle));
  if (3.0 * rhythm.cycle > usual || rhythm.longest > usual)
    choice.timeout = std::ceil(needed / resolution - 1e-6) * resolution;
  choice.buses = rhythm.buses;
  if (rhythm.buses.size() > 1) {
    choice.bus = rhythm.buses.front();
    choice.buses = {choice.bus};
    choice.warnings.push_back(
        fmt::format("frames of this identifier come on {}; taken from the busiest",
                    fmt::join(rhythm.buses, " and ")));
  }
}

/// Keeps one kind of speed: if possible that of both wheels of an axle, otherwise of the rear axle,
/// otherwise of the motor.
void keep_one_speed(Proposal& proposal) {
  const bool pair = proposal.has_axle();
  if (pair) {
    proposal.of(Source::wheel_rear).reset();
  } else if (proposal.has(Source::wheel_rear)) {
    for (const Source role : wheel_sources)
      if (is_single_wheel(role)) proposal.of(role).reset();
  }
  if (pair || proposal.has(Source::wheel_rear)) proposal.of(Source::motor).reset();
}

void require_speed(const Proposal& proposal, std::span<const can::Database> databases,
                   const Traffic& traffic, const std::vector<std::string>& absent) {
  if (std::ranges::any_of(wheel_sources, [&](Source role) { return proposal.has(role); })) return;
  std::vector<std::string> files;
  for (const can::Database& database : databases) files.push_back(database.file);
  if (!absent.empty())
    refuse(
        "{}: has no frame of a speed: {} {} in {}, but not in the log; log the bus that "
        "carries it, or check the database",
        traffic.name, fmt::join(absent, ", "), absent.size() == 1 ? "is" : "are",
        fmt::join(files, ", "));
  refuse(
      "{}: no signal looks like a wheel's or the car's speed, which odomd needs; write "
      "car.toml by hand: odom dbc show lists the signals, odomd.toml(5) the roles",
      fmt::join(files, ", "));
}

/// Drops the sign signal of a speed if it is already mapped as the gear.
void keep_one_direction(Proposal& proposal) {
  const auto& gear = proposal.of(Source::direction);
  for (const Source role : wheel_sources)
    if (auto& choice = proposal.of(role); choice && gear && choice->candidate.sign &&
                                          choice->candidate.sign->signal == gear->candidate.signal)
      choice->candidate.sign.reset();
}

/// Notes that the speeds have no sign and that there is no gear.
void add_speed_notes(Proposal& proposal) {
  bool signed_speed = false;
  for (const Source role : wheel_sources)
    if (const auto& choice = proposal.of(role)) {
      const can::Signal& signal = *choice->candidate.signal;
      signed_speed = signed_speed || choice->candidate.sign || signal.minimum < 0.0 ||
                     (signal.maximum <= signal.minimum && signal.offset < 0.0);
    }
  if (!signed_speed && !proposal.has(Source::direction))
    proposal.notes.emplace_back(
        "the speeds have no sign, and no gear was found: in reverse the pose will move forward; "
        "map "
        "direction");
}

}  // namespace

bool Proposal::has_axle() const {
  return std::ranges::any_of(estimator::wheel_pairs,
                             [&](const auto& pair) { return has(pair.first) && has(pair.second); });
}

Proposal propose(std::span<const can::Database> databases, const Traffic& traffic) {
  const bool has_log = !traffic.empty();
  const Rhythms came = rhythms(traffic, databases);
  Proposal proposal;
  std::vector<std::string> absent_speeds;
  for (const Source role : estimator::all_sources) {
    if (role == Source::camera) continue;
    std::vector<Candidate> candidates = candidates_for(role, databases);
    std::string absent;
    if (has_log)
      std::erase_if(candidates, [&](const Candidate& candidate) {
        const bool gone = !came.contains(key_of(candidate));
        if (gone && absent.empty()) absent = candidate.name();
        return gone;
      });
    if (candidates.empty()) {
      if (!absent.empty() && role != Source::direction)
        proposal.notes.push_back(fmt::format("{}: {} is in the database, but not in the log",
                                             info_of(role).name, absent));
      if (!absent.empty() && estimator::is_wheel(role)) absent_speeds.push_back(absent);
      continue;
    }
    std::vector<Choice> choices;
    for (Candidate& candidate : candidates) {
      Series series = series_of(traffic, databases, candidate);
      choices.push_back({.candidate = std::move(candidate), .series = std::move(series)});
    }
    Choice choice = best_of(std::move(choices), has_log);
    if (has_log) apply_rhythm(choice, came.at(key_of(choice.candidate)));
    proposal.of(role) = std::move(choice);
  }
  require_speed(proposal, databases, traffic, absent_speeds);
  keep_one_speed(proposal);
  keep_one_direction(proposal);
  add_speed_notes(proposal);
  if (!has_log) {
    proposal.notes.emplace_back(
        "without a log nothing was compared with a drive; only names, units and ranges were used");
    for (auto& choice : proposal.roles)
      if (choice) choice->warnings.emplace_back("from the database alone; give --can with a drive");
  }
  return proposal;
}

}  // namespace odomd::tools
