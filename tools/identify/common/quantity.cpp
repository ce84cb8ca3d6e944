#include "tools/identify/common/quantity.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

struct UnitName {
  std::string_view name;
  double factor;
  Unit unit = Unit::si;
};

constexpr UnitName masses[] = {{"kg", 1.0}, {"g", 1e-3}, {"N", 1.0, Unit::newton}};
constexpr UnitName lengths[] = {{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}};
constexpr UnitName angles[] = {{"rad", 1.0}, {"deg", std::numbers::pi / 180.0}};
constexpr UnitName times[] = {{"s", 1.0}, {"ms", 1e-3}};
constexpr UnitName pure_numbers[] = {{"", 1.0}, {"%", 1e-2}};

std::span<const UnitName> names_of(Dimension dimension) {
  switch (dimension) {
    case Dimension::mass:
      return masses;
    case Dimension::length:
      return lengths;
    case Dimension::angle:
      return angles;
    case Dimension::time:
      return times;
    case Dimension::pure:
      break;
  }
  return pure_numbers;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

double parse_si(std::string_view text, Dimension dimension, std::string_view option) {
  const Quantity quantity = parse_quantity(text, dimension, option);
  if (quantity.unit == Unit::newton)
    throw std::invalid_argument(fmt::format("{}: {}: give it in kg or g", option, quoted(text)));
  return quantity.value;
}

}  // namespace

std::string_view units_of(Dimension dimension) {
  switch (dimension) {
    case Dimension::mass:
      return "kg, g or N";
    case Dimension::length:
      return "m, cm or mm";
    case Dimension::angle:
      return "rad or deg";
    case Dimension::time:
      return "s or ms";
    case Dimension::pure:
      break;
  }
  return "no unit, or %";
}

Quantity parse_quantity(std::string_view text, Dimension dimension, std::string_view option) {
  const std::string_view whole = trimmed(text);
  double value = 0.0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), value);
  if (error != std::errc{} || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("{}: {} is not a number", option, quoted(text)));
  const std::string_view unit = trimmed(whole.substr(static_cast<std::size_t>(end - whole.data())));
  const std::span<const UnitName> names = names_of(dimension);
  if (unit.empty()) return {value, names.front().unit};
  for (const UnitName& name : names)
    if (name.name == unit) return {value * name.factor, name.unit};
  if (unit.front() == ',')
    throw std::invalid_argument(
        fmt::format("{}: {}: write a decimal point, not a comma", option, quoted(text)));
  throw std::invalid_argument(
      fmt::format("{}: {}: the unit must be {}", option, quoted(text), units_of(dimension)));
}

double parse_positive(std::string_view text, Dimension dimension, std::string_view option) {
  const double value = parse_si(text, dimension, option);
  if (value > 0.0) return value;
  throw std::invalid_argument(
      fmt::format("{}: {} is not possible; it must be greater than 0", option, quoted(text)));
}

double parse_not_negative(std::string_view text, Dimension dimension, std::string_view option) {
  const double value = parse_si(text, dimension, option);
  if (value >= 0.0) return value;
  throw std::invalid_argument(
      fmt::format("{}: {} is not possible; it must be 0 or greater", option, quoted(text)));
}

double parse_or(double otherwise, std::string_view text, Dimension dimension,
                std::string_view option) {
  return text.empty() ? otherwise : parse_not_negative(text, dimension, option);
}

double parse_plausible(std::string_view text, Dimension dimension, std::string_view option,
                       Plausible range) {
  const double value = parse_positive(text, dimension, option);
  if (value >= range.from && value <= range.to) return value;
  const std::string_view unit = names_of(dimension).front().name;
  throw std::invalid_argument(fmt::format(
      "{}: {} is {:.4g} {}, but {:g} to {:g} {} is plausible; a number without a unit "
      "is in {}; units are {}",
      option, quoted(text), value, unit, range.from, range.to, unit, unit, units_of(dimension)));
}

}  // namespace odomd::tools
