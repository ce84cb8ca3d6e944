#include "tools/identify/fit/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "base/nearest_name.hpp"
#include "tools/cli/text.hpp"
#include "tools/identify/common/quantity.hpp"

namespace odomd::tools::fitting {
namespace {

constexpr std::array<ParameterInfo, parameters> table{{
    {stiffness_front, "stiffness_front", Kind::factor, Role::result, "N/rad",
     "cornering stiffness, front"},
    {stiffness_rear, "stiffness_rear", Kind::factor, Role::result, "N/rad",
     "cornering stiffness, rear"},
    {yaw_inertia, "yaw_inertia", Kind::factor, Role::result, "kg m2", "yaw inertia"},
    {relaxation_length, "relaxation_length", Kind::factor, Role::nuisance, "m",
     "relaxation length of the tyres"},
    {bend_front, "bend_front", Kind::factor, Role::nuisance, "", "how front tyres saturate"},
    {bend_rear, "bend_rear", Kind::factor, Role::nuisance, "", "how rear tyres saturate"},
    {load_arm, "load_arm", Kind::factor, Role::nuisance, "m", "how stiffness goes with load"},
    {load_lag, "load_lag", Kind::factor, Role::nuisance, "s", "how late load follows a turn"},
    {wheel_spin, "wheel_spin", Kind::factor, Role::nuisance, "",
     "spin of the front wheels by mass"},
    {drive_spin, "drive_spin", Kind::factor, Role::nuisance, "",
     "spin of the rear wheels and what drives them, by mass"},
    {track_width, "track_width", Kind::factor, Role::result, "m", "track width"},
    {steering_offset, "steering_offset", Kind::shift, Role::result, "rad", "steering offset"},
    {steering_scale, "steering_scale", Kind::factor, Role::result, "", "steering scale"},
    {steering_delay, "steering_delay", Kind::shift, Role::result, "s", "steering, delay in all"},
    {steering_lag, "steering_lag", Kind::factor, Role::result, "s", "steering, time constant"},
    {gyro_bias, "gyro_bias", Kind::shift, Role::result, "rad/s", "gyro bias"},
    {gyro_scale, "gyro_scale", Kind::factor, Role::result, "", "gyro scale"},
    {gyro_latency, "gyro_latency", Kind::shift, Role::result, "s", "gyro latency"},
    {accel_bias_x, "accel_bias_x", Kind::shift, Role::result, "m/s2", "accelerometer bias, x"},
    {accel_bias_y, "accel_bias_y", Kind::shift, Role::result, "m/s2", "accelerometer bias, y"},
    {accel_scale, "accel_scale", Kind::factor, Role::nuisance, "", "accelerometer scale"},
    {accel_latency, "accel_latency", Kind::shift, Role::result, "s", "accelerometer latency"},
    {imu_x, "imu_x", Kind::shift, Role::result, "m", "IMU ahead of the centre of gravity"},
    {imu_y, "imu_y", Kind::shift, Role::result, "m", "IMU left of the centre of gravity"},
    {imu_yaw, "imu_yaw", Kind::shift, Role::result, "rad", "IMU mounting yaw"},
    {wheel_scale_front_left, "wheel_scale_front_left", Kind::factor, Role::result, "",
     "wheel scale, front left"},
    {wheel_scale_front_right, "wheel_scale_front_right", Kind::factor, Role::result, "",
     "wheel scale, front right"},
    {wheel_scale_rear_left, "wheel_scale_rear_left", Kind::factor, Role::result, "",
     "wheel scale, rear left"},
    {wheel_scale_rear_right, "wheel_scale_rear_right", Kind::factor, Role::result, "",
     "wheel scale, rear right"},
    {wheel_scale_rear, "wheel_scale_rear", Kind::factor, Role::result, "",
     "wheel scale, rear axle"},
    {wheel_scale_motor, "wheel_scale_motor", Kind::factor, Role::result, "", "wheel scale, motor"},
    {wheel_slip, "wheel_slip", Kind::shift, Role::nuisance, "", "slip of driven wheels"},
    {wheel_latency_front, "wheel_latency_front", Kind::shift, Role::result, "s",
     "wheel latency, front"},
    {wheel_latency_rear, "wheel_latency_rear", Kind::shift, Role::result, "s",
     "wheel latency, rear"},
    {camera_x, "camera_x", Kind::shift, Role::result, "m",
     "camera's point ahead of the centre of gravity"},
    {camera_y, "camera_y", Kind::shift, Role::result, "m",
     "camera's point left of the centre of gravity"},
    {camera_yaw, "camera_yaw", Kind::shift, Role::result, "rad", "camera mounting yaw"},
}};

constexpr bool in_order() {
  for (std::size_t i = 0; i < table.size(); ++i)
    if (table[i].parameter != i) return false;
  return true;
}
static_assert(in_order());

const can::SignalBinding* binding_of(const daemon::Config& config, estimator::Source source) {
  for (const can::SignalBinding& binding : config.can.bindings)
    if (binding.channel == static_cast<std::uint16_t>(source)) return &binding;
  return nullptr;
}

const ParameterInfo* find(std::string_view name) {
  const auto* const found = std::ranges::find(table, name, &ParameterInfo::name);
  return found == table.end() ? nullptr : found;
}

std::vector<std::string> names_of_all() {
  std::vector<std::string> names;
  names.reserve(table.size() + 1);
  for (const ParameterInfo& info : table) names.emplace_back(info.name);
  return names;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string list = "; available:";
  for (const std::string& name : names) list += ' ' + name;
  return list;
}

[[noreturn]] void refuse_name(std::string_view name, const std::vector<std::string>& names) {
  const bool misspelt = resembles(name, nearest_name(name, names));
  throw std::invalid_argument("\"" + std::string(name) + "\" is not a parameter of the fit" +
                              (misspelt ? nearest_hint(name, names) : list_of(names)));
}

// The unit of a prior's sigma: a share for factors and for the mass, which is not a parameter.
Dimension dimension_of(const ParameterInfo* info) {
  if (info == nullptr || info->kind == Kind::factor) return Dimension::pure;
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
    throw std::invalid_argument("--prior " + text +
                                ": expected NAME=SIGMA with a SIGMA above 0, such as "
                                "yaw_inertia=0.02 or yaw_inertia=2%");
  const std::string name = text.substr(0, equals);
  const ParameterInfo* const info = find(name);
  if (info == nullptr && name != "mass") {
    std::vector<std::string> names = names_of_all();
    names.emplace_back("mass");
    refuse_name(name, names);
  }
  const double sigma = parse_positive(number, dimension_of(info), "--prior " + name);
  if (sigma > 1.0 && (info == nullptr || info->kind == Kind::factor))
    throw std::invalid_argument("--prior " + text + ": would be " + fixed(100.0 * sigma, 0) +
                                " %; give how uncertain " + name +
                                " is as a share of it, 1 at most: 0.02 for 2 %");
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
  const auto latency = [&](Source source) {
    const can::SignalBinding* binding = binding_of(config, source);
    return binding == nullptr ? 0.0 : 1e-9 * static_cast<double>(binding->latency_ns);
  };
  Numbers<double> value{};
  value[stiffness_front] = car.cornering_stiffness_front;
  value[stiffness_rear] = car.cornering_stiffness_rear;
  value[yaw_inertia] = car.yaw_inertia;
  value[relaxation_length] = 0.17 * car.wheelbase();
  value[bend_front] = value[bend_rear] = 0.7;
  value[load_arm] = 0.14 * car.wheelbase();
  value[load_lag] = 0.05 * std::sqrt(car.wheelbase());
  value[wheel_spin] = 0.015;
  value[drive_spin] = 0.042;  // 0.7 of two wheels' mass, a geared motor as much again
  value[track_width] = car.track_width;
  value[steering_scale] = 1.0;
  const estimator::SteeringActuator& servo = car.steering;
  const bool commanded = servo.delay_s > 0.0 || servo.lag_s > 0.0;
  value[steering_delay] = commanded ? servo.delay_s + servo.lag_s : 0.05;
  value[steering_lag] = servo.lag_s > 0.0 ? servo.lag_s : 0.05;
  value[gyro_scale] = value[accel_scale] = 1.0;
  value[gyro_latency] = latency(Source::yaw_rate);
  value[accel_latency] = latency(Source::accel_y);
  value[imu_x] = config.imu_position[0];
  value[imu_y] = config.imu_position[1];
  value[imu_yaw] = config.imu_yaw;
  for (std::size_t k = wheel_scale_front_left; k <= wheel_scale_motor; ++k) value[k] = 1.0;
  value[wheel_slip] = usual_slip;
  value[wheel_latency_front] = latency(Source::wheel_front_left);
  for (const Source source : {Source::motor, Source::wheel_rear, Source::wheel_rear_left})
    if (binding_of(config, source) != nullptr) value[wheel_latency_rear] = latency(source);
  value[camera_x] = config.camera.lever_arm[0];
  value[camera_y] = config.camera.lever_arm[1];
  value[camera_yaw] = config.camera.lever_arm[2];
  return value;
}

Numbers<double> default_prior_sigmas(const daemon::Config& config) {
  const double wheelbase = config.vehicle.wheelbase();
  Numbers<double> prior_sigma{};
  prior_sigma[stiffness_front] = prior_sigma[stiffness_rear] = 0.4;
  prior_sigma[yaw_inertia] = 0.05;
  prior_sigma[relaxation_length] = 0.5;
  prior_sigma[bend_front] = prior_sigma[bend_rear] = 0.5;
  prior_sigma[load_arm] = 0.5;
  prior_sigma[load_lag] = prior_sigma[wheel_spin] = 0.3;
  prior_sigma[drive_spin] = 0.5;
  prior_sigma[track_width] = 0.03;
  prior_sigma[steering_offset] = 0.05;
  prior_sigma[steering_scale] = 0.05;
  prior_sigma[steering_delay] = 0.1;
  prior_sigma[steering_lag] = 0.8;
  prior_sigma[gyro_bias] = 0.05;
  prior_sigma[gyro_scale] = 0.05;
  prior_sigma[gyro_latency] = 0.05;
  prior_sigma[accel_bias_x] = prior_sigma[accel_bias_y] = 1.0;
  prior_sigma[accel_scale] = 0.02;
  prior_sigma[accel_latency] = 0.05;
  prior_sigma[imu_x] = prior_sigma[imu_y] = 0.2 * wheelbase;
  prior_sigma[imu_yaw] = 0.05;
  for (std::size_t k = wheel_scale_front_left; k <= wheel_scale_motor; ++k) prior_sigma[k] = 0.1;
  prior_sigma[wheel_slip] = 0.4;
  prior_sigma[wheel_latency_front] = prior_sigma[wheel_latency_rear] = 0.05;
  prior_sigma[camera_x] = prior_sigma[camera_y] = 0.5 * wheelbase;
  prior_sigma[camera_yaw] = 0.1;
  return prior_sigma;
}

double value_of(const ParameterInfo& info, double nominal, double p) {
  return info.kind == Kind::factor ? nominal * std::exp(p) : nominal + p;
}

}  // namespace odomd::tools::fitting
