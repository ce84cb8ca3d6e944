// A role is described by groups of words. Each group must match a word in the name of the signal or
// of its message, or the unit.
#include "tools/init/proposal.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "can_protocol/decode/units.hpp"
#include "tools/init/words.hpp"

namespace odomd::tools {
namespace {

using can::NameWords;
using estimator::Quantity;
using estimator::Side;
using estimator::Source;
using namespace role_words;

/// The corner of the car that a name states: 0 to 3 as in corner_codes; -1: none.
int corner_of(const NameWords& name) {
  for (std::size_t i = 0; i < corner_codes.size(); ++i)
    if (has_word(name, corner_codes[i])) return static_cast<int>(i);
  const bool in_front = has(name, front), behind = has(name, rear);
  const bool at_left = has(name, left), at_right = has(name, right);
  if (in_front == behind || at_left == at_right) return -1;
  return (in_front ? 0 : 2) + (at_left ? 0 : 1);
}

constexpr auto axis_words = std::to_array<std::string_view>({"x", "ax", "y", "ay"});
constexpr auto rate_word = std::to_array<std::string_view>({"rate"});

struct Seen {
  NameWords own, around;  ///< of the signal and of its message
  can::Dimension dimension = can::Dimension::none;
};

/// How well a signal fits a role, and why it may not.
struct Fit {
  const Seen& seen;
  double score = 0.0;
  std::vector<std::string> warnings;
  bool possible = true;
  bool in_own_name = false;  ///< a word of the signal's own name describes the role

  constexpr static double in_name = 3.0, in_message = 1.5, by_unit = 1.0;

  /// Requires a word of the group in a name, or the role's unit if `unit_says_it`.
  void need(Vocabulary words, bool unit_says_it = false) {
    if (has(seen.own, words)) {
      score += in_name;
      in_own_name = true;
    } else if (has(seen.around, words)) {
      score += in_message;
    } else if (unit_says_it) {
      score += by_unit;
    } else {
      possible = false;
    }
  }
  void warn(std::string why, double cost = 0.0) {
    score -= cost;
    warnings.push_back(std::move(why));
  }
};

void fit_wheel(Fit& fit, int corner) {
  const int own = corner_of(fit.seen.own);
  const int stated = own >= 0 ? own : corner_of(fit.seen.around);
  if (stated != corner) fit.possible = false;
  fit.in_own_name = own >= 0;
  fit.score += own >= 0 ? Fit::in_name : Fit::in_message;
  fit.need(wheel);
  if (!has(fit.seen.own, speed)) fit.score -= 0.5;
}

void fit_one_speed(Fit& fit) {
  const bool of_wheel = has(fit.seen.own, wheel) || has(fit.seen.around, wheel);
  if ((of_wheel && corner_of(fit.seen.own) >= 0) || has(fit.seen.own, front) ||
      has(fit.seen.own, motor) || (!of_wheel && has(fit.seen.around, motor)) ||
      has(fit.seen.own, left) || has(fit.seen.own, right))
    fit.possible = false;  // the speed of another axle or of a single wheel
  fit.need(speed, of_wheel);
  if (!of_wheel)
    fit.warn(
        "the name has no wheel; a speed that is not measured at wheels may be late or rounded");
  else if (!has(fit.seen.own, rear))
    fit.warn("the name does not say which wheel; assumed to be the mean of the rear axle");
  if (of_wheel) fit.score += 2.0 * Fit::in_name;
  if (has(fit.seen.own, rear)) fit.score += Fit::in_name;
  if (!of_wheel && !has(fit.seen.own, car) && !has(fit.seen.around, car)) fit.score -= 1.0;
}

can::Unit usual_unit(Source role) {
  switch (info_of(role).quantity) {
    case Quantity::yaw_rate:
      return can::Unit::deg_per_s;
    case Quantity::acceleration:
      return can::Unit::m_per_s2;
    case Quantity::angle:
      return can::Unit::deg;
    default:
      return can::Unit::km_per_h;
  }
}

can::Dimension dimension_of(Source role) {
  return role == Source::direction ? can::Dimension::none : can::dimension_of(usual_unit(role));
}

void fit_words(Fit& fit, Source role) {
  // Two groups of words describe the role; a unit may replace one of them. Words of the signal's
  // own name that belong to `others` exclude the role.
  const auto describe = [&](Vocabulary what, bool unit_says_what, Vocabulary which,
                            bool unit_says_which, std::initializer_list<Vocabulary> others) {
    fit.need(what, unit_says_what);
    fit.need(which, unit_says_which);
    for (const Vocabulary other : others)
      if (has(fit.seen.own, other)) fit.possible = false;
  };
  const can::Dimension unit = fit.seen.dimension;
  if (role == Source::yaw_rate) {
    describe(yaw, false, rate, unit == can::Dimension::angular_rate, {steering});
    if (has_word(fit.seen.own, axis_words) ||
        (has(fit.seen.own, acceleration) && unit == can::Dimension::none))
      fit.possible = false;
  } else if (role == Source::accel_x) {
    describe(acceleration, unit == can::Dimension::acceleration, along, false, {across});
  } else if (role == Source::accel_y) {
    describe(acceleration, unit == can::Dimension::acceleration, across, false, {along});
  } else if (role == Source::motor) {
    describe(motor, false, speed, unit == can::Dimension::speed, {});
  } else if (role == Source::steering) {
    describe(steering, false, angle, true, {rear, speed});
    if (has_word(fit.seen.own, rate_word)) fit.possible = false;
  } else if (role == Source::wheel_rear) {
    fit_one_speed(fit);
  } else if (!is_single_wheel(role)) {
    fit.possible = false;
  } else {
    fit_wheel(fit, (is_front(role) ? 0 : 2) + (info_of(role).side == Side::left ? 0 : 1));
  }
}

/// Whether the role can have the dimension; wheel speeds may be sent as angular velocities.
bool is_unit_of(Source role, can::Dimension dimension) {
  return dimension == dimension_of(role) ||
         (estimator::is_wheel(role) && dimension == can::Dimension::angular_rate);
}

/// Whether the unit is that of a ratio or a count, which only a steering command can have.
bool is_dimensionless(std::string_view text) {
  const auto unit = can::unit_of_text(text);
  if (unit) return can::dimension_of(*unit) == can::Dimension::none;
  const NameWords words = can::words_of(text);
  return words.size() == 1 && has_word(words, no_dimension);
}

bool is_another(const Seen& seen) {
  return has_word(seen.own, other_quantity) || has_word(seen.own, other_thing) ||
         has_word(seen.around, other_thing);
}

Fit fit_of(Source role, const Seen& seen, const can::Signal& signal) {
  Fit fit{.seen = seen, .score = 0.0, .warnings = {}};
  constexpr int shortest = 8;  // bits
  const bool other = can::is_other_unit(signal.unit) ||
                     (is_dimensionless(signal.unit) && role != Source::steering);
  const bool fits = is_unit_of(role, seen.dimension);
  if (other || signal.length < shortest || (seen.dimension != can::Dimension::none && !fits) ||
      is_another(seen)) {
    fit.possible = false;
    return fit;
  }
  fit_words(fit, role);
  fit.possible = fit.possible && fit.in_own_name;
  if (!fit.possible) return fit;
  if (fits)
    fit.score += 3.0;
  else
    fit.warn("the database gives no known unit");
  if (has_word(seen.own, perhaps_other))
    fit.warn("the name may mean a command or a status", 4.0);
  else if (has_word(seen.around, other_quantity) || has_word(seen.around, perhaps_other) ||
           has_word(seen.around, std::to_array<std::string_view>({"acc"})))
    fit.score -= 2.0;
  if (signal.multiplexor) fit.warn("it is multiplexed", 1.0);
  constexpr double per_word = 0.1;  // prefers the plainest name
  fit.score -= per_word * static_cast<double>(seen.own.size());
  return fit;
}

/// The fine part of a coarse signal: "STEER_FRACTION" of "STEER_ANGLE", in the same message.
const can::Signal* fraction_of(const can::Message& message, const can::Signal& coarse) {
  const NameWords name = split_words(coarse.name);
  for (const can::Signal& fine : message.signals) {
    const NameWords words = split_words(fine.name);
    if (&fine != &coarse && fine.unit == coarse.unit && has(words, fraction_words) &&
        words.front() == name.front() && fine.scale < coarse.scale)
      return &fine;
  }
  return nullptr;
}

std::optional<double> value_named(const can::Signal& signal, Vocabulary names) {
  for (const can::ValueName& value : signal.values) {
    const NameWords words = can::words_of(value.name);
    if (words.size() == 1 && std::ranges::find(names, words.front()) != names.end())
      return static_cast<double>(value.raw) * signal.scale + signal.offset;
  }
  return std::nullopt;
}

void add_direction(const can::Message& message, const can::Signal& signal,
                   std::vector<Candidate>& found) {
  constexpr auto onward =
      std::to_array<std::string_view>({"d", "drive", "forward", "forwards", "vorwaerts"});
  constexpr auto back =
      std::to_array<std::string_view>({"r", "reverse", "backward", "backwards", "rueckwaerts"});
  const auto forward = value_named(signal, onward), reverse = value_named(signal, back);
  const NameWords own = split_words(signal.name), around = split_words(message.name);
  if (!forward || !reverse || is_another({own, around})) return;
  Candidate candidate{.role = Source::direction, .message = &message, .signal = &signal};
  candidate.forward = forward;
  candidate.reverse = reverse;
  candidate.score = has(own, gear) ? Fit::in_name : has(around, gear) ? Fit::in_message : 0.0;
  if (has(own, gear_lever)) {
    candidate.score -= Fit::in_message;
    candidate.warnings.emplace_back("the name may mean the lever, not the gear");
  }
  found.push_back(std::move(candidate));
}

}  // namespace

std::vector<Candidate> candidates_for(Source role, std::span<const can::Database> databases) {
  std::vector<Candidate> found;
  for (const can::Database& database : databases)
    for (const can::Message& message : database.messages) {
      const NameWords around = split_words(message.name);
      for (const can::Signal& signal : message.signals) {
        if (role == Source::direction) {
          add_direction(message, signal, found);
          continue;
        }
        const auto unit = can::unit_of_text(signal.unit);
        const Seen seen{split_words(signal.name), around,
                        unit ? can::dimension_of(*unit) : can::Dimension::none};
        Fit fit = fit_of(role, seen, signal);
        if (!fit.possible || has(seen.own, fraction_words)) continue;
        Candidate& candidate = found.emplace_back();
        candidate.role = role;
        candidate.message = &message;
        candidate.signal = &signal;
        candidate.unit = seen.dimension != can::Dimension::none ? *unit : usual_unit(role);
        candidate.score = fit.score;
        candidate.warnings = std::move(fit.warnings);
        candidate.valid_when = validity_of(message, signal);
        candidate.sign = sign_of(message, signal);
        if (auto raws = invalid_raws(signal); !raws.empty())
          candidate.unless_raw = {can::UnlessRaw::Pattern::listed, std::move(raws)};
        if (role == Source::motor && has_word(seen.own, {&electrical, 1}))
          candidate.unit = can::Unit::erpm;
        if (role == Source::steering) candidate.fraction = fraction_of(message, signal);
      }
    }
  std::ranges::stable_sort(found, std::ranges::greater{}, &Candidate::score);
  if (constexpr std::size_t enough = 8; found.size() > enough) found.resize(enough);
  return found;
}

}  // namespace odomd::tools
