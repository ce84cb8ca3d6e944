#include "tools/tune/parameter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

constexpr std::size_t most_values = 1000;

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw std::invalid_argument(
      "--set " + tools::quoted(text) + ": " + why +
      "; as in --set filter.front_angle_error=0.01:0.2 (a range to search), "
      "=0.01:0.2:5 (five values) or =0.01,0.1,0.2 (these)");
}

double number(const std::string& whole, std::string_view text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [after, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || after != end || !std::isfinite(value))
    refuse(whole, tools::quoted(text) + " is not a finite number");
  return value;
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(text.find(at, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    if (end == text.size()) return parts;
    begin = end + 1;
  }
}

double four_digits(double value) {
  if (value == 0.0) return 0.0;
  const std::string text = fmt::format("{:.4g}", value);
  double rounded = value;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

}  // namespace

Parameter parse_parameter(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse(text, "has no key and range");
  Parameter parameter;
  parameter.key = text.substr(0, equals);
  const std::string_view range = std::string_view{text}.substr(equals + 1);

  const auto bounds = split(range, ':');
  if (bounds.size() == 1) {
    for (const std::string_view value : split(range, ','))
      parameter.values.push_back(number(text, value));
    const auto [least, most] = std::ranges::minmax(parameter.values);
    parameter.from = least;
    parameter.to = most;
    return parameter;
  }
  if (bounds.size() > 3) refuse(text, "has more than FROM:TO:N");
  parameter.from = number(text, bounds[0]);
  parameter.to = number(text, bounds[1]);
  if (parameter.from >= parameter.to) refuse(text, "FROM is not below TO");
  parameter.scale = parameter.from > 0.0 ? Scale::logarithmic : Scale::linear;
  if (bounds.size() == 3) {
    const double count = number(text, bounds[2]);
    if (count != std::floor(count) || count < 2.0 || count > static_cast<double>(most_values))
      refuse(text, fmt::format("N is 2 to {}", most_values));
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
      parameter.values.push_back(value_at(parameter, static_cast<double>(i) / (count - 1.0)));
  }
  return parameter;
}

double value_at(const Parameter& parameter, double place) {
  const double value = parameter.scale == Scale::logarithmic
                           ? parameter.from * std::pow(parameter.to / parameter.from, place)
                           : parameter.from + place * (parameter.to - parameter.from);
  return std::clamp(four_digits(value), parameter.from, parameter.to);
}

double place_of(const Parameter& parameter, double value) {
  const double held = std::clamp(value, parameter.from, parameter.to);
  return parameter.scale == Scale::logarithmic
             ? std::log(held / parameter.from) / std::log(parameter.to / parameter.from)
             : (held - parameter.from) / (parameter.to - parameter.from);
}

}  // namespace odomd::tools
