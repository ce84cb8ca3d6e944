#include "tools/identify/fit/parameters.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/nearest_name.hpp"
#include "tools/cli/text.hpp"
#include "tools/identify/common/inputs.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools::fitting {
namespace {

using enum ParameterKind;

constexpr std::array<ParameterInfo, parameters> table{{
#define ODOMD_FIT(name, ...) {name, #name, __VA_ARGS__},
#include "tools/identify/fit/parameters.inc"
#undef ODOMD_FIT
}};

const ParameterInfo* find(std::string_view name) {
  const auto* const found = std::ranges::find(table, name, &ParameterInfo::name);
  return found == table.end() ? nullptr : found;
}

std::vector<std::string> names_of_all() {
  std::vector<std::string> names;
  for (const ParameterInfo& info : table) names.emplace_back(info.name);
  return names;
}

[[noreturn]] void refuse_name(std::string_view name, const std::vector<std::string>& names) {
  const bool misspelt = resembles(name, nearest_name(name, names));
  refuse(
      "\"{}\" is not a parameter of the fit{}", name,
      misspelt ? nearest_hint(name, names) : fmt::format("; available: {}", fmt::join(names, " ")));
}

// The unit of a prior's sigma: relative for factors and for the mass, which is not a parameter.
Dimension dimension_of(const ParameterInfo* info) {
  if (info == nullptr || info->kind == factor) return Dimension::pure;
  if (info->unit == "m") return Dimension::length;
  if (info->unit == "rad") return Dimension::angle;
  if (info->unit == "s") return Dimension::time;
  return Dimension::pure;
}

}  // namespace

const std::array<ParameterInfo, parameters>& parameter_table() {
  return table;
}

const ParameterInfo& parameter_named(std::string_view name) {
  if (const ParameterInfo* const info = find(name)) return *info;
  refuse_name(name, names_of_all());
}

Prior parse_prior(const std::string& text) {
  const std::size_t equals = std::min(text.find('='), text.size());
  const std::string_view number = std::string_view{text}.substr(std::min(equals + 1, text.size()));
  if (number.empty())
    refuse(
        "--prior {}: expected NAME=SIGMA with a SIGMA above 0, such as yaw_inertia=0.02 or "
        "yaw_inertia=2%",
        text);
  const std::string name = text.substr(0, equals);
  const ParameterInfo* const info = find(name);
  if (info == nullptr && name != "mass") {
    std::vector<std::string> names = names_of_all();
    names.emplace_back("mass");
    refuse_name(name, names);
  }
  const double sigma = parse_positive(number, dimension_of(info), "--prior " + name);
  if (sigma > 1.0 && (info == nullptr || info->kind == factor))
    refuse(
        "--prior {}: would be {} %; give how uncertain {} is as a share of it, 1 at most: 0.02 for "
        "2 %",
        text, fixed(100.0 * sigma, 0), name);
  if (info == nullptr) return {std::nullopt, sigma};
  return {info->parameter, sigma};
}

bool one_imu(const daemon::Config& config) {
  const can::SignalBinding* gyro = binding_of(config, estimator::Source::yaw_rate);
  if (gyro == nullptr) return false;
  const auto with_the_gyro = [&](estimator::Source source) {
    const can::SignalBinding* accel = binding_of(config, source);
    return accel == nullptr ||
           (accel->message == gyro->message && accel->latency_ns == gyro->latency_ns);
  };
  return with_the_gyro(estimator::Source::accel_x) && with_the_gyro(estimator::Source::accel_y);
}

Numbers<double> nominal_values(const daemon::Config& config) {
  using estimator::Source;
  const estimator::Vehicle& car = config.vehicle;
  Numbers<double> value{};
  for (const ParameterInfo& info : table) value[info.parameter] = info.kind == factor ? 1.0 : 0.0;
  value[stiffness_front] = car.cornering_stiffness_front;
  value[stiffness_rear] = car.cornering_stiffness_rear;
  value[yaw_inertia] = car.yaw_inertia;
  value[relaxation_length] = 0.17 * car.wheelbase();
  value[bend_front] = value[bend_rear] = 0.7;
  value[load_arm] = 0.14 * car.wheelbase();
  value[load_lag] = 0.05 * std::sqrt(car.wheelbase());
  value[wheel_spin] = 0.015;
  value[drive_spin] = 0.042;  // 0.7 of two wheels' mass, and the same again for a geared motor
  value[track_width] = car.track_width;
  const estimator::SteeringActuator& servo = car.steering;
  const bool commanded = servo.delay_s > 0.0 || servo.lag_s > 0.0;
  value[steering_delay] = commanded ? servo.delay_s + servo.lag_s : 0.05;
  value[steering_lag] = servo.lag_s > 0.0 ? servo.lag_s : 0.05;
  value[gyro_latency] = configured_latency(config, Source::yaw_rate);
  value[accel_latency] = configured_latency(config, Source::accel_y);
  value[imu_x] = config.imu_position[0];
  value[imu_y] = config.imu_position[1];
  value[imu_yaw] = config.imu_yaw;
  value[wheel_slip] = usual_slip;
  value[wheel_latency_front] = configured_latency(config, Source::wheel_front_left);
  for (const Source source : {Source::motor, Source::wheel_rear, Source::wheel_rear_left})
    if (binding_of(config, source) != nullptr)
      value[wheel_latency_rear] = configured_latency(config, source);
  value[camera_x] = config.camera.lever_arm[0];
  value[camera_y] = config.camera.lever_arm[1];
  value[camera_yaw] = config.camera.lever_arm[2];
  return value;
}

Numbers<double> sigmas_of(double ParameterInfo::*which, double wheelbase) {
  Numbers<double> sigma{};
  for (const ParameterInfo& info : table)
    sigma[info.parameter] =
        info.*which * (info.kind == shift && info.unit == "m" ? wheelbase : 1.0);
  return sigma;
}

double value_of(const ParameterInfo& info, double nominal, double p) {
  return info.kind == factor ? nominal * std::exp(p) : nominal + p;
}

}  // namespace odomd::tools::fitting
