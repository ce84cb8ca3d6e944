#include "tools/sim/car/parameters.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/nearest_name.hpp"
#include "tools/math/random.hpp"

namespace odomd::sim {
namespace {

using enum Parameter;
using enum Draw;
using enum Nature;

std::string shortest(double value) {
  std::array<char, 32> text{};
  char* const end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

}  // namespace

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
  std::string hint = misspelt ? nearest_hint(name, names) : "; available:";
  for (std::size_t i = 0; i < names.size() && !misspelt; ++i)
    hint += (i == 0 ? " " : ", ") + names[i];
  throw std::invalid_argument("\"" + std::string(name) + "\" is not a parameter of the simulation" +
                              hint);
}

Assignment parse_assignment(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos)
    throw std::invalid_argument("\"" + std::string(text) + "\": expected NAME=VALUE");
  const ParameterInfo& info = find_parameter(text.substr(0, equals));
  const std::string_view number = text.substr(equals + 1);
  double value = 0.0;
  const auto [end, status] = std::from_chars(number.data(), number.data() + number.size(), value);
  if (status != std::errc{} || end != number.data() + number.size() || !std::isfinite(value))
    throw std::invalid_argument("\"" + std::string(text) + "\": \"" + std::string(number) +
                                "\" is not a finite number");
  return {info.parameter, value};
}

std::vector<Assignment> slow_servo() {
  return {{steering_delay, 0.06},
          {steering_lag, 0.1},
          {steering_rate_limit, 3.0},
          {steering_commanded, 1.0}};
}

void check(const ParameterInfo& info, double value) {
  if (value >= info.minimum && value <= info.maximum) return;
  throw std::invalid_argument(std::string(info.name) + ": must lie between " +
                              shortest(info.minimum) + " and " + shortest(info.maximum));
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
