// Units and their spellings.
#include "can_protocol/decode/units.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <string>

namespace odomd::can {
namespace {

struct Row {
  Unit unit;
  std::string_view name;
  double si_factor;
  Dimension dimension;
  std::string_view spellings;  ///< as normalised() returns them, separated by blanks
};

constexpr double degree = std::numbers::pi / 180.0;
constexpr double turns_per_minute = 2.0 * std::numbers::pi / 60.0;
constexpr double standard_gravity = 9.80665;

/// In the order of Unit.
constexpr std::array rows{
    Row{Unit::none, "1", 1.0, Dimension::none, ""},
    Row{Unit::rad, "rad", 1.0, Dimension::angle, "rad"},
    Row{Unit::deg, "deg", degree, Dimension::angle, "deg"},
    Row{Unit::rad_per_s, "rad/s", 1.0, Dimension::angular_rate, "rad/s rads-1"},
    Row{Unit::deg_per_s, "deg/s", degree, Dimension::angular_rate, "deg/s dps"},
    Row{Unit::m_per_s, "m/s", 1.0, Dimension::speed, "m/s mps ms-1"},
    Row{Unit::km_per_h, "km/h", 1.0 / 3.6, Dimension::speed, "km/h kph kmh kmph"},
    Row{Unit::rpm, "rpm", turns_per_minute, Dimension::speed, "rpm 1/min min-1 u/min r/min"},
    Row{Unit::erpm, "erpm", turns_per_minute, Dimension::speed, "erpm er/min"},
    Row{Unit::m_per_s2, "m/s2", 1.0, Dimension::acceleration, "m/s2 m/s/s ms-2 mps2"},
    Row{Unit::g, "g", standard_gravity, Dimension::acceleration, "g"},
    Row{Unit::percent, "%", 0.01, Dimension::none, "%"}};

constexpr const Row& row_of(Unit unit) {
  return rows[static_cast<std::size_t>(unit)];
}
static_assert(rows.size() == static_cast<std::size_t>(Unit::percent) + 1, "every unit has a row");
static_assert(std::ranges::all_of(rows, [](const Row& row) { return &row_of(row.unit) == &row; }));

/// Units that no role accepts, normalised as above.
constexpr std::string_view other_units =
    "mph mi/h mile/h miles/h mm/s cm/s ft/s knots kt kts mrad mrad/s mdeg mdeg/s mdps rad/s2 "
    "deg/s2 m/s3 mm/s2 cm/s2 ft/s2 mg rps r/s 1/s hz khz m mm cm km s ms min h v mv volt volts a "
    "ma amps w kw nm n kg bar kpa degc celsius";

/// Whether the blank-separated list contains the word.
bool has_word(std::string_view list, std::string_view word) {
  for (std::size_t at = 0; !word.empty() && at < list.size();) {
    const std::size_t end = std::min(list.find(' ', at), list.size());
    if (list.substr(at, end - at) == word) return true;
    at = end + 1;
  }
  return false;
}

/// Words and their symbols in the order of replacement: the prefix of a word comes after it. Some
/// editors cut words off: "Unit_DegreOfArcPerSecon".
constexpr std::string_view words =
    "unit_= percent=% pct=% ofarc= forceofgravity=g forceofgravi=g minuteinverse=1/min "
    "minutinver=1/min per=/ squared=2 square=2 squar=2 milli=m centi=c kilo=k meters=m metres=m "
    "meter=m metre=m degrees=deg degree=deg degre=deg radians=rad radian=rad seconds=s second=s "
    "secon=s sec=s hours=h hour=h hr=h minutes=min minute=min revolutions=r revolution=r "
    "rotations=r rev=r ";

void replace_all(std::string& text, std::string_view what, std::string_view by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at))
    text.replace(at, what.size(), by), at += by.size();
}

std::string normalised(std::string_view unit) {
  std::string text(unit);
  for (const std::string_view sign : {"\u00B0", "\u00BA", "\u02DA"})  // °, º, ˚
    replace_all(text, sign, "deg");
  replace_all(text, "\u00B2", "2");  // ²
  replace_all(text, "\u207B", "-");  // ⁻
  replace_all(text, "\u00B9", "1");  // ¹
  replace_all(text, "\u2212", "-");  // −
  for (const std::string_view noise : {"^", "*", " ", "\t", "\u00B7", "(", ")", "[", "]"})
    replace_all(text, noise, "");
  std::transform(text.begin(), text.end(), text.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  for (std::string_view rest = words; !rest.empty();) {
    const std::size_t equals = rest.find('=');
    const std::size_t end = rest.find(' ');
    replace_all(text, rest.substr(0, equals), rest.substr(equals + 1, end - equals - 1));
    rest.remove_prefix(end + 1);
  }
  return text;
}

}  // namespace

std::optional<Unit> unit_of_text(std::string_view text) {
  const std::string wanted = normalised(text);
  for (const Row& row : rows)
    if (has_word(row.spellings, wanted)) return row.unit;
  return std::nullopt;
}

bool is_other_unit(std::string_view text) {
  const std::string other = normalised(text);
  return other == "%" || has_word(other_units, other);
}

std::string_view unit_name(Unit unit) noexcept {
  return row_of(unit).name;
}

double si_factor(Unit unit) noexcept {
  return row_of(unit).si_factor;
}

Dimension dimension_of(Unit unit) noexcept {
  return row_of(unit).dimension;
}

}  // namespace odomd::can
