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

// After normalisation: lower case, no blanks, no '^', no '*', a plain 2, "deg" for the degree
// signs.
constexpr std::array spellings{Spelling{"rad", Unit::rad},
                               Spelling{"radian", Unit::rad},
                               Spelling{"radians", Unit::rad},
                               Spelling{"deg", Unit::deg},
                               Spelling{"degree", Unit::deg},
                               Spelling{"degrees", Unit::deg},
                               Spelling{"rad/s", Unit::rad_per_s},
                               Spelling{"rad/sec", Unit::rad_per_s},
                               Spelling{"radians/s", Unit::rad_per_s},
                               Spelling{"rads-1", Unit::rad_per_s},
                               Spelling{"rad/second", Unit::rad_per_s},
                               Spelling{"radians/sec", Unit::rad_per_s},
                               Spelling{"radians/second", Unit::rad_per_s},
                               Spelling{"deg/s", Unit::deg_per_s},
                               Spelling{"deg/second", Unit::deg_per_s},
                               Spelling{"degree/second", Unit::deg_per_s},
                               Spelling{"degrees/second", Unit::deg_per_s},
                               Spelling{"deg/sec", Unit::deg_per_s},
                               Spelling{"degree/s", Unit::deg_per_s},
                               Spelling{"degrees/s", Unit::deg_per_s},
                               Spelling{"degrees/sec", Unit::deg_per_s},
                               Spelling{"degree/sec", Unit::deg_per_s},
                               Spelling{"dps", Unit::deg_per_s},
                               Spelling{"m/s", Unit::m_per_s},
                               Spelling{"m/sec", Unit::m_per_s},
                               Spelling{"m/second", Unit::m_per_s},
                               Spelling{"meters/sec", Unit::m_per_s},
                               Spelling{"meters/second", Unit::m_per_s},
                               Spelling{"metres/second", Unit::m_per_s},
                               Spelling{"mps", Unit::m_per_s},
                               Spelling{"ms-1", Unit::m_per_s},
                               Spelling{"km/h", Unit::km_per_h},
                               Spelling{"km/hr", Unit::km_per_h},
                               Spelling{"kph", Unit::km_per_h},
                               Spelling{"kmh", Unit::km_per_h},
                               Spelling{"kmph", Unit::km_per_h},
                               Spelling{"rpm", Unit::rpm},
                               Spelling{"1/min", Unit::rpm},
                               Spelling{"min-1", Unit::rpm},
                               Spelling{"u/min", Unit::rpm},
                               Spelling{"r/min", Unit::rpm},
                               Spelling{"rev/min", Unit::rpm},
                               Spelling{"m/s2", Unit::m_per_s2},
                               Spelling{"m/s/s", Unit::m_per_s2},
                               Spelling{"m/sec2", Unit::m_per_s2},
                               Spelling{"m/second2", Unit::m_per_s2},
                               Spelling{"ms-2", Unit::m_per_s2},
                               Spelling{"mps2", Unit::m_per_s2},
                               Spelling{"g", Unit::g}};

// Normalised as above.
constexpr std::array<std::string_view, 58> others{
    "mph",   "mi/h",    "mile/h",  "miles/h", "mm/s",   "cm/s",  "ft/s",   "knots",  "kt",
    "kts",   "mrad",    "mrad/s",  "mdeg",    "mdeg/s", "mdps",  "rad/s2", "deg/s2", "m/s3",
    "mm/s2", "cm/s2",   "ft/s2",   "mg",      "rps",    "rev/s", "1/s",    "hz",     "khz",
    "%",     "percent", "m",       "mm",      "cm",     "km",    "meter",  "meters", "s",
    "sec",   "second",  "seconds", "ms",      "min",    "h",     "v",      "mv",     "volt",
    "volts", "a",       "ma",      "amps",    "w",      "kw",    "nm",     "n",      "kg",
    "bar",   "kpa",     "degc",    "celsius"};

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
  return std::find(others.begin(), others.end(), normalised(text)) != others.end();
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
    case Unit::m_per_s2:
      return "m/s2";
    case Unit::g:
      return "g";
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
    case Unit::rpm:
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
