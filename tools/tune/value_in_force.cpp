#include "tools/tune/value_in_force.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace odomd::tools {
namespace {

constexpr double seconds(std::int64_t nanoseconds) {
  return 1e-9 * static_cast<double>(nanoseconds);
}

std::optional<double> of_signal(const daemon::Config& config, std::string_view role,
                                std::string_view name) {
  const auto binding = std::ranges::find(config.can.bindings, role, &can::SignalBinding::role);
  if (binding == config.can.bindings.end()) return std::nullopt;
  const daemon::SignalSettings& settings = config.can.signals[binding->channel];
  if (name == "scale") return binding->scale;
  if (name == "offset") return binding->offset;
  if (name == "latency") return seconds(binding->latency_ns);
  if (name == "sigma") return settings.sigma;
  if (name == "timeout") return seconds(settings.timeout_ns);
  if (name == "dead_band" && settings.dead_band > 0.0) return settings.dead_band;
  return std::nullopt;
}

}  // namespace

std::optional<double> value_in_force(const daemon::Config& config, std::string_view key) {
  constexpr std::string_view signals = "can.signals.";
  if (key.starts_with(signals)) {
    const std::string_view rest = key.substr(signals.size());
    const std::size_t dot = rest.find('.');
    if (dot == std::string_view::npos) return std::nullopt;
    return of_signal(config, rest.substr(0, dot), rest.substr(dot + 1));
  }
  const estimator::Vehicle& car = config.vehicle;
  const estimator::Tuning& tuning = config.tuning;
  // Limits: without one there is no number.
  const std::pair<std::string_view, double> limits[] = {
      {"vehicle.grip_front", car.grip_front},
      {"vehicle.grip_rear", car.grip_rear},
      {"steering.rate_limit", car.steering.rate_limit},
  };
  for (const auto& [name, limit] : limits)
    if (name == key) return limit > 0.0 ? std::optional(limit) : std::nullopt;
  const std::pair<std::string_view, double> numbers[] = {
      {"vehicle.mass", car.mass},
      {"vehicle.front_axle", car.front_axle},
      {"vehicle.rear_axle", car.rear_axle},
      {"vehicle.yaw_inertia", car.yaw_inertia},
      {"vehicle.cornering_stiffness_front", car.cornering_stiffness_front},
      {"vehicle.cornering_stiffness_rear", car.cornering_stiffness_rear},
      {"vehicle.track_width", car.track_width},
      {"steering.delay", car.steering.delay_s},
      {"steering.lag", car.steering.lag_s},
      {"camera.lever_arm[0]", config.camera.lever_arm[0]},
      {"camera.lever_arm[1]", config.camera.lever_arm[1]},
      {"camera.lever_arm[2]", config.camera.lever_arm[2]},
      {"camera.max_latency", config.camera.max_latency_s},
      {"imu.position[0]", config.imu_position[0]},
      {"imu.position[1]", config.imu_position[1]},
      {"imu.yaw", config.imu_yaw},
      {"imu.roll_gradient", config.roll_gradient.value_or(0.0)},
      {"imu.pitch_gradient", config.pitch_gradient.value_or(0.0)},
      {"realtime.period", seconds(config.realtime.period_ns)},
      {"filter.window", config.window_s},
      {"filter.camera_gate", config.camera_gate},
      {"filter.gyro_bias_walk", tuning.gyro_bias_walk},
      {"filter.gyro_scale_walk", tuning.gyro_scale_walk},
      {"filter.accel_bias_walk", tuning.accel_bias_walk},
      {"filter.wheel_scale_walk", tuning.wheel_scale_walk},
      {"filter.steering_offset_walk", tuning.steering_offset_walk},
      {"filter.stiffness_scale_walk", tuning.stiffness_scale_walk},
      {"filter.front_angle_error", tuning.front_angle},
      {"filter.side_slip_error", tuning.side_slip},
      {"filter.wheel_radius_error", tuning.wheel_radius},
      {"filter.wheel_slip", tuning.wheel_slip},
      {"filter.paper_q[0]", config.paper_noise.Q[0]},
      {"filter.paper_q[1]", config.paper_noise.Q[1]},
      {"filter.paper_q[2]", config.paper_noise.Q[2]},
      {"filter.paper_r[0]", config.paper_noise.R[0]},
      {"filter.paper_r[1]", config.paper_noise.R[1]},
  };
  const auto* const found =
      std::ranges::find(numbers, key, &std::pair<std::string_view, double>::first);
  if (found == std::end(numbers)) return std::nullopt;
  return found->second;
}

}  // namespace odomd::tools
