#include "tools/identify/common/quantity.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "tools/cli/csv.hpp"
#include "tools/cli/refuse.hpp"

namespace odomd::tools {
namespace {

struct UnitName {
  std::string_view name;
  double per_si;  // units per SI unit: 175 / 1000 is 0.175, 175 * 1e-3 is not
};

struct Units {
  std::string_view in_words;
  std::array<UnitName, 3> names;  // the SI unit first
};

// In the order of Dimension.
constexpr std::array<Units, 5> units{{
    {"kg or g", {{{"kg", 1.0}, {"g", 1e3}}}},
    {"m, cm or mm", {{{"m", 1.0}, {"cm", 1e2}, {"mm", 1e3}}}},
    {"rad or deg", {{{"rad", 1.0}, {"deg", 180.0 / std::numbers::pi}}}},
    {"s or ms", {{{"s", 1.0}, {"ms", 1e3}}}},
    {"no unit, or %", {{{"", 1.0}, {"%", 1e2}}}},
}};

const Units& of(Dimension dimension) {
  return units[static_cast<std::size_t>(dimension)];
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

}  // namespace

double parse_quantity(std::string_view text, Dimension dimension, std::string_view option) {
  const std::string_view whole = trimmed(text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), value);
  if (error != std::errc{} || !std::isfinite(value))
    refuse("{}: {} is not a number", option, quoted(text));
  const std::string_view unit = trimmed(whole.substr(static_cast<std::size_t>(end - whole.data())));
  if (unit.empty()) return value;
  for (const UnitName& name : of(dimension).names)
    if (name.name == unit) return value / name.per_si;
  if (unit.front() == ',')
    refuse("{}: {}: write a decimal point, not a comma", option, quoted(text));
  refuse("{}: {}: the unit must be {}", option, quoted(text), of(dimension).in_words);
}

double parse_positive(std::string_view text, Dimension dimension, std::string_view option) {
  const double value = parse_quantity(text, dimension, option);
  if (value > 0.0) return value;
  refuse("{}: {} is not possible; it must be greater than 0", option, quoted(text));
}

double parse_not_negative(std::string_view text, Dimension dimension, std::string_view option) {
  const double value = parse_quantity(text, dimension, option);
  if (value >= 0.0) return value;
  refuse("{}: {} is not possible; it must be 0 or greater", option, quoted(text));
}

double parse_or(double otherwise, std::string_view text, Dimension dimension,
                std::string_view option) {
  return text.empty() ? otherwise : parse_not_negative(text, dimension, option);
}

double parse_plausible(std::string_view text, Dimension dimension, std::string_view option,
                       Plausible range) {
  const double value = parse_positive(text, dimension, option);
  if (value >= range.from && value <= range.to) return value;
  const std::string_view unit = of(dimension).names.front().name;
  refuse(
      "{}: {} is {:.4g} {}, but {:g} to {:g} {} is plausible; a number without a unit "
      "is in {}; units are {}",
      option, quoted(text), value, unit, range.from, range.to, unit, unit, of(dimension).in_words);
}

void add_measured_option(Command method) {
  method.add_measurements(
      "--measured", "JSON",
      "Measurements written down in a file: {\"total\": [2.985, 2.986], "
      "\"spacing\": \"200mm\"}; names are those of the options, with underscores");
}

}  // namespace odomd::tools
