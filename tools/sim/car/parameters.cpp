#include "tools/sim/car/parameters.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
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

constexpr std::array<ParameterInfo, parameter_count> table{{
#define ODOMD_PARAMETER(name, ...) {name, #name, __VA_ARGS__},
#include "tools/sim/car/parameters.inc"
#undef ODOMD_PARAMETER
}};

// Defaults in which the cars with published data, and their sensors, differ from the saloon.
constexpr double degree = std::numbers::pi / 180.0;
constexpr std::array sprung{
    Assignment{friction, 1.0489},          // friction of their tyres, p_Dy1: vehicle.cpp
    Assignment{steering_rate_limit, 0.4},  // also published: v_max of the road wheels
    Assignment{stiffness_error_front, 0.1},
    Assignment{stiffness_error_rear, 0.1},
    Assignment{gyro_scale_error, 0.0},
    Assignment{gyro_bias, 0.3 * degree},
    Assignment{gyro_noise, 0.1 * degree},
    Assignment{accel_noise, 0.1},
    Assignment{noise_at_rest, 0.2},
    Assignment{wheel_radius_error, 0.0},
    Assignment{wheel_radius_error_front_left, 0.005},
    Assignment{wheel_radius_error_front_right, 0.005},
    Assignment{wheel_radius_error_rear_left, 0.005},
    Assignment{wheel_radius_error_rear_right, 0.005},
    Assignment{wheel_noise, 0.0},
    Assignment{wheel_step, 0.01},
    Assignment{encoder_counts, 0.0},
    Assignment{steering_offset, 0.3 * degree},
    Assignment{imu_cycle, 0.01},
    Assignment{wheel_cycle, 0.02},
    Assignment{camera_period, 0.05},
    Assignment{camera_latency_min, 0.06},
    Assignment{camera_latency_max, 0.1},
    Assignment{camera_noise, 0.05},
    Assignment{camera_yaw_noise, 0.3 * degree},
};

std::string shortest(double value) {
  std::array<char, 32> text{};
  char* const end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

}  // namespace

std::span<const ParameterInfo, parameter_count> parameter_table() {
  return table;
}

ParameterSet default_parameters(CarKind car) {
  ParameterSet result;
  for (const ParameterInfo& info : table)
    result[info.parameter] = car == CarKind::scale_car ? info.scale_car : info.saloon;
  if (is_sprung(car))
    for (const Assignment& own : sprung) result[own.parameter] = own.value;
  return result;
}

double sprung_default(Parameter parameter) {
  return default_parameters(CarKind::bmw_320i)[parameter];
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
