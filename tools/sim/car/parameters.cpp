#include "tools/sim/car/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/nearest_name.hpp"
#include "tools/cli/csv.hpp"
#include "tools/math/random.hpp"

namespace odomd::sim {
namespace {

using enum Parameter;
using enum Draw;
using enum Nature;

constexpr double degree = std::numbers::pi / 180.0;

constexpr std::array<ParameterInfo, parameter_count> table{{
#define ODOMD_PARAMETER(name, ...) {name, #name, __VA_ARGS__},
#include "tools/sim/car/parameters.inc"
#undef ODOMD_PARAMETER
}};

}  // namespace

std::span<const ParameterInfo, parameter_count> parameter_table() {
  return table;
}

ParameterSet default_parameters(CarKind car) {
  ParameterSet result;
  for (const ParameterInfo& info : table)
    result[info.parameter] = car == CarKind::scale_car ? info.scale_car
                             : is_sprung(car)          ? info.published
                                                       : info.saloon;
  return result;
}

void make_ideal(ParameterSet& parameters) {
  for (const ParameterInfo& info : parameter_table())
    if (info.nature == error) parameters[info.parameter] = 0.0;
}

const ParameterInfo& find_parameter(std::string_view name) {
  std::vector<std::string> names;
  for (const ParameterInfo& info : parameter_table()) {
    if (info.name == name) return info;
    names.emplace_back(info.name);
  }
  const bool misspelt =
      std::ranges::any_of(names, [&](const std::string& known) { return resembles(name, known); });
  throw std::invalid_argument(
      fmt::format("\"{}\" is not a parameter of the simulation{}", name,
                  misspelt ? nearest_hint(name, names)
                           : fmt::format("; available: {}", fmt::join(names, ", "))));
}

Assignment parse_assignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos)
    throw std::invalid_argument(fmt::format("\"{}\": expected NAME=VALUE", text));
  const ParameterInfo& info = find_parameter(text.substr(0, equals));
  const std::string_view number = text.substr(equals + 1);
  const std::optional<double> value = tools::parse_number(number);
  if (!value || !std::isfinite(*value))
    throw std::invalid_argument(fmt::format("\"{}\": \"{}\" is not a finite number", text, number));
  return {info.parameter, *value};
}

std::vector<Assignment> slow_servo() {
  return {{steering_delay, 0.06},
          {steering_lag, 0.1},
          {steering_rate_limit, 3.0},
          {steering_commanded, 1.0}};
}

void check(const ParameterInfo& info, double value) {
  if (value >= info.minimum && value <= info.maximum) return;
  throw std::invalid_argument(
      fmt::format("{}: must lie between {} and {}", info.name, info.minimum, info.maximum));
}

ParameterSet draw_truth(const ParameterSet& sizes, std::uint64_t seed) {
  ParameterSet truth;
  for (const ParameterInfo& info : parameter_table()) {
    RandomStream stream(seed, info.name);
    const double size = sizes[info.parameter];
    switch (info.draw) {
      case exact:
        truth[info.parameter] = size;
        break;
      case normal:
        truth[info.parameter] = size * stream.normal();
        break;
      case uniform:
        truth[info.parameter] = size * stream.uniform(-1.0, 1.0);
        break;
    }
  }
  return truth;
}

}  // namespace odomd::sim
