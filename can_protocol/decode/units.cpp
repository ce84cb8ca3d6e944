// Units and their spellings.
#include "can_protocol/decode/units.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <string>
#include <utility>

namespace odomd::can {
namespace {

using Spelling = std::pair<std::string_view, Unit>;

// As normalised() returns them: lower case, no blanks, signs or prefixes, symbols for words.
constexpr std::array spellings{Spelling{"rad", Unit::rad},
                               Spelling{"deg", Unit::deg},
                               Spelling{"rad/s", Unit::rad_per_s},
                               Spelling{"rads-1", Unit::rad_per_s},
                               Spelling{"deg/s", Unit::deg_per_s},
                               Spelling{"dps", Unit::deg_per_s},
                               Spelling{"m/s", Unit::m_per_s},
                               Spelling{"mps", Unit::m_per_s},
                               Spelling{"ms-1", Unit::m_per_s},
                               Spelling{"km/h", Unit::km_per_h},
                               Spelling{"kph", Unit::km_per_h},
                               Spelling{"kmh", Unit::km_per_h},
                               Spelling{"kmph", Unit::km_per_h},
                               Spelling{"rpm", Unit::rpm},
                               Spelling{"1/min", Unit::rpm},
                               Spelling{"min-1", Unit::rpm},
                               Spelling{"u/min", Unit::rpm},
                               Spelling{"r/min", Unit::rpm},
                               Spelling{"erpm", Unit::erpm},
                               Spelling{"er/min", Unit::erpm},
                               Spelling{"m/s2", Unit::m_per_s2},
                               Spelling{"m/s/s", Unit::m_per_s2},
                               Spelling{"ms-2", Unit::m_per_s2},
                               Spelling{"mps2", Unit::m_per_s2},
                               Spelling{"g", Unit::g},
                               Spelling{"%", Unit::percent}};

// Units that no role accepts, normalised as above.
constexpr std::array<std::string_view, 51> others{
    "mph",   "mi/h",  "mile/h", "miles/h", "mm/s",   "cm/s",   "ft/s",   "knots",  "kt",
    "kts",   "mrad",  "mrad/s", "mdeg",    "mdeg/s", "mdps",   "rad/s2", "deg/s2", "m/s3",
    "mm/s2", "cm/s2", "ft/s2",  "mg",      "rps",    "r/s",    "1/s",    "hz",     "khz",
    "m",     "mm",    "cm",     "km",      "s",      "ms",     "min",    "h",      "v",
    "mv",    "volt",  "volts",  "a",       "ma",     "amps",   "w",      "kw",     "nm",
    "n",     "kg",    "bar",    "kpa",     "degc",   "celsius"};

/// Words and their symbols in the order of replacement: a word that begins another comes later.
/// Some editors cut words off: "Unit_DegreOfArcPerSecon".
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
  for (const std::string_view degree : {"\u00B0", "\u00BA", "\u02DA"})  // °, º, ˚
    replace_all(text, degree, "deg");
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
  for (const auto& [spelling, unit] : spellings)
    if (spelling == wanted) return unit;
  return std::nullopt;
}

bool is_other_unit(std::string_view text) {
  const std::string other = normalised(text);
  return other == "%" || std::ranges::find(others, other) != others.end();
}

std::string_view unit_name(Unit unit) noexcept {
  switch (unit) {
    case Unit::none:
      return "1";
    case Unit::rad:
      return "rad";
    case Unit::deg:
      return "deg";
    case Unit::rad_per_s:
      return "rad/s";
    case Unit::deg_per_s:
      return "deg/s";
    case Unit::m_per_s:
      return "m/s";
    case Unit::km_per_h:
      return "km/h";
    case Unit::rpm:
      return "rpm";
    case Unit::erpm:
      return "erpm";
    case Unit::m_per_s2:
      return "m/s2";
    case Unit::g:
      return "g";
    case Unit::percent:
      return "%";
  }
  return "";
}

double si_factor(Unit unit) noexcept {
  switch (unit) {
    case Unit::deg:
    case Unit::deg_per_s:
      return std::numbers::pi / 180.0;
    case Unit::km_per_h:
      return 1.0 / 3.6;
    case Unit::percent:
      return 0.01;
    case Unit::rpm:
    case Unit::erpm:
      return 2.0 * std::numbers::pi / 60.0;
    case Unit::g:
      return 9.80665;  // standard gravity
    case Unit::none:
    case Unit::rad:
    case Unit::rad_per_s:
    case Unit::m_per_s:
    case Unit::m_per_s2:
      return 1.0;
  }
  return 1.0;
}

}  // namespace odomd::can
