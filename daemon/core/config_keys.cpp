#include "daemon/core/config_keys.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "estimator/integrity/admission.hpp"

namespace odomd::daemon {
namespace {

using estimator::PaperNoise;
using estimator::SteeringActuator;
using estimator::Tuning;
using estimator::Vehicle;

template <auto... members>
constexpr auto at = [](Config& config) -> auto& {
  return (config.*....*members);
};
template <auto member>
constexpr auto car = at<&Config::vehicle, member>;
template <auto member>
constexpr auto servo = at<&Config::vehicle, &Vehicle::steering, member>;
template <auto member>
constexpr auto camera = at<&Config::camera, member>;
template <auto member>
constexpr auto camera_socket = at<&Config::camera, &CameraConfig::socket, member>;
template <auto member>
constexpr auto tuning = at<&Config::tuning, member>;

constexpr std::array<std::string_view, 7> level_names{"trace", "debug",    "info", "warn",
                                                      "error", "critical", "off"};
constexpr std::array<std::string_view, 2> timestamp_names{"software", "hardware"};
/// In the order of estimator::Driven.
constexpr std::array<std::string_view, 3> driven_names{"rear", "front", "all"};

constexpr Range fraction{1e-9, 1.0, true, "1e-9 to 1"};
constexpr Range lean{-0.5, 0.5, true, "-0.5 to 0.5 (rad per g)"};

// Two groups of tyres: the rear ones determine the side slip, the front ones the response to
// steering, which the gyro measures better.
constexpr std::string_view front = "front tyres", rear = "rear tyres", axles = "axles",
                           actuator = "steering actuator", imu = "place of the IMU",
                           view = "place of the camera";

void set_driven(Config& config, std::size_t name) {
  config.vehicle.driven = static_cast<estimator::Driven>(name);
}
void set_timestamps(Config& config, std::size_t name) {
  config.can.timestamps = static_cast<Timestamps>(name);
}
void set_level(Config& config, std::size_t name) {
  config.log.level = level_names[name];
}

std::string_view problem_of_name(const Config& config) {
  const std::string& name = config.shm.name;
  return name.size() < 2 || name.front() != '/' ? "must begin with a slash: \"/odomd\", or a path"
                                                : "";
}
std::string_view problem_of_mode(const Config& config) {
  return (config.shm.mode & ~0644U) != 0 || (config.shm.mode & 0600U) != 0600U
             ? "must be 0o600, 0o640 or 0o644: clients refuse what others may write"
             : "";
}
std::string_view problem_of_pose(const Config& config) {
  return config.initial_pose && !is_possible(*config.initial_pose) ? pose_too_far : "";
}

constexpr ConfigKey keys[] = {
    {"vehicle", "mass", car<&Vehicle::mass>, positive},
    {"vehicle", "front_axle", car<&Vehicle::front_axle>, positive, axles},
    {"vehicle", "rear_axle", car<&Vehicle::rear_axle>, positive, axles},
    {"vehicle", "yaw_inertia", car<&Vehicle::yaw_inertia>, positive, "yaw inertia"},
    {"vehicle", "cornering_stiffness_front", car<&Vehicle::cornering_stiffness_front>, positive,
     front},
    {"vehicle", "cornering_stiffness_rear", car<&Vehicle::cornering_stiffness_rear>, positive,
     rear},
    {"vehicle", "track_width", car<&Vehicle::track_width>, positive, "track width"},
    {"vehicle", "grip_front", car<&Vehicle::grip_front>, positive, front},
    {"vehicle", "grip_rear", car<&Vehicle::grip_rear>, positive, rear},
    {"vehicle", "driven", Choice{driven_names, set_driven}},
    {"can", "timestamps", Choice{timestamp_names, set_timestamps}},
    {"can", "receive_buffer", at<&Config::can, &CanConfig::receive_buffer>, Range{4096, 1 << 30}},
    {"camera", "socket", camera_socket<&SocketConfig::path>},
    {"camera", "socket_mode", camera_socket<&SocketConfig::mode>},
    {"camera", "socket_group", camera_socket<&SocketConfig::group>},
    {"camera", "lever_arm", camera<&CameraConfig::lever_arm>, any_number, view},
    {"camera", "max_latency", camera<&CameraConfig::max_latency_s>,
     Range{0.0, 10.0, false, "between 0 and 10 (s)"}},
    {"reference", "lever_arm", at<&Config::reference_lever_arm>},
    {"steering", "delay", servo<&SteeringActuator::delay_s>, Range{0.0, 0.5, true, "0 to 0.5 (s)"},
     actuator},
    {"steering", "lag", servo<&SteeringActuator::lag_s>, Range{0.0, 1.0, true, "0 to 1 (s)"},
     actuator},
    {"steering", "rate_limit", servo<&SteeringActuator::rate_limit>, positive, actuator},
    {"imu", "position", at<&Config::imu_position>, any_number, imu},
    {"imu", "yaw", at<&Config::imu_yaw>, Range{-3.15, 3.15, true, "-3.15 to 3.15 (rad)"}, imu},
    {"imu", "roll_gradient", at<&Config::roll_gradient>, lean, imu},
    {"imu", "pitch_gradient", at<&Config::pitch_gradient>, lean, imu},
    {"initial", "pose", at<&Config::initial_pose>, any_number, {}, problem_of_pose},
    {"filter", "model", at<&Config::model>},
    {"filter", "window", at<&Config::window_s>,
     Range{shortest_window_s, longest_window_s, true, "0.2 to 1 (s)"}},
    {"filter", "camera_gate", at<&Config::camera_gate>, Range{1.0, 1e6, true, "1 to 1e6"}},
    {"filter", "gyro_bias_walk", tuning<&Tuning::gyro_bias_walk>, fraction},
    {"filter", "gyro_scale_walk", tuning<&Tuning::gyro_scale_walk>, fraction},
    {"filter", "accel_bias_walk", tuning<&Tuning::accel_bias_walk>, fraction},
    {"filter", "wheel_scale_walk", tuning<&Tuning::wheel_scale_walk>, fraction},
    {"filter", "steering_offset_walk", tuning<&Tuning::steering_offset_walk>, fraction},
    {"filter", "stiffness_scale_walk", tuning<&Tuning::stiffness_scale_walk>, fraction},
    {"filter", "front_angle_error", tuning<&Tuning::front_angle>, fraction},
    {"filter", "side_slip_error", tuning<&Tuning::side_slip>,
     Range{1e-9, 10.0, true, "1e-9 to 10"}},
    {"filter", "wheel_radius_error", tuning<&Tuning::wheel_radius>,
     Range{0.0, 0.5, true, "0 to 0.5"}},
    {"filter", "wheel_slip", tuning<&Tuning::wheel_slip>, fraction},
    {"filter", "paper_q", at<&Config::paper_noise, &PaperNoise::Q>, positive},
    {"filter", "paper_r", at<&Config::paper_noise, &PaperNoise::R>, positive},
    {"realtime", "period", at<&Config::realtime, &RealtimeConfig::period_ns>,
     Range{0.001, 0.1, true, "0.001 to 0.1 (s)"}},
    {"realtime", "priority", at<&Config::realtime, &RealtimeConfig::priority>, Range{2, 99}},
    {"realtime", "cpu", at<&Config::realtime, &RealtimeConfig::cpu>, Range{-1, 1023}},
    {"shm", "name", at<&Config::shm, &ShmConfig::name>, any_number, {}, problem_of_name},
    {"shm", "mode", at<&Config::shm, &ShmConfig::mode>, any_number, {}, problem_of_mode},
    {"shm", "group", at<&Config::shm, &ShmConfig::group>},
    {"status", "socket", at<&Config::status, &SocketConfig::path>},
    {"status", "socket_mode", at<&Config::status, &SocketConfig::mode>},
    {"status", "socket_group", at<&Config::status, &SocketConfig::group>},
    {"record", "socket", at<&Config::record, &SocketConfig::path>},
    {"log", "file", at<&Config::log, &LogConfig::file>},
    {"log", "level", Choice{level_names, set_level}},
};

static_assert(keys[numbers_of_a_car - 1].name == "track_width" &&
              keys[numbers_of_a_car].name == "grip_front");

}  // namespace

std::span<const ConfigKey> config_keys() {
  return keys;
}

const ConfigKey* config_key(std::string_view path) {
  path = path.substr(0, path.find('['));
  const auto* const found = std::ranges::find_if(keys, [&](const ConfigKey& key) {
    return path == fmt::format("{}.{}", key.table, key.name);
  });
  return found == std::end(keys) ? nullptr : found;
}

}  // namespace odomd::daemon
