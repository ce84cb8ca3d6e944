// load_config(): reads the tables of the file. Long tables have files of their own.
#include "daemon/core/config.hpp"

#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "daemon/core/config_sections.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::daemon {
namespace {

constexpr std::array<std::string_view, 7> level_names{"trace", "debug",    "info", "warn",
                                                      "error", "critical", "off"};

/// In the order of estimator::Driven.
constexpr std::array<std::string_view, 3> driven_names{"rear", "front", "all"};

/// All keys or none: a mixture of two cars would give wrong poses.
estimator::Vehicle read_vehicle(TableReader table) {
  estimator::Vehicle vehicle;
  const std::pair<std::string_view, double*> keys[] = {
      {"mass", &vehicle.mass},
      {"front_axle", &vehicle.front_axle},
      {"rear_axle", &vehicle.rear_axle},
      {"yaw_inertia", &vehicle.yaw_inertia},
      {"cornering_stiffness_front", &vehicle.cornering_stiffness_front},
      {"cornering_stiffness_rear", &vehicle.cornering_stiffness_rear},
      {"track_width", &vehicle.track_width},
  };
  for (const auto& [key, value] : keys) table.read(key, *value, positive);
  table.read("grip_front", vehicle.grip_front, positive);
  table.read("grip_rear", vehicle.grip_rear, positive);
  if (const auto axle = table.read_choice("driven", driven_names))
    vehicle.driven = static_cast<estimator::Driven>(*axle);
  table.finish();
  for (const auto& [key, value] : keys)
    if (!table.has(key))
      table.fail(key, "is missing; give all keys of [vehicle], or leave the table out");
  return vehicle;
}

estimator::SteeringActuator read_steering(TableReader table) {
  estimator::SteeringActuator actuator;
  table.read("delay", actuator.delay_s, {0.0, 0.5, true, "0 to 0.5 (s)"});
  table.read("lag", actuator.lag_s, {0.0, 1.0, true, "0 to 1 (s)"});
  table.read("rate_limit", actuator.rate_limit, positive);
  table.finish();
  return actuator;
}

CameraConfig read_camera(TableReader table) {
  CameraConfig camera;
  camera.configured = true;
  table.read("socket", camera.socket);
  table.read_mode("socket_mode", camera.socket_mode);
  table.read("socket_group", camera.socket_group);
  table.read("lever_arm", camera.lever_arm, any_number);
  table.read("max_latency", camera.max_latency_s, {0.0, 10.0, false, "between 0 and 10 (s)"});
  table.finish();
  return camera;
}

RealtimeConfig read_realtime(TableReader table) {
  RealtimeConfig realtime;
  table.read_seconds("period", realtime.period_ns, {0.001, 0.1, true, "0.001 to 0.1 (s)"});
  table.read("priority", realtime.priority, 2, 99);
  table.read("cpu", realtime.cpu, -1, 1023);
  table.finish();
  return realtime;
}

ShmConfig read_shm(TableReader table) {
  ShmConfig shm;
  table.read("name", shm.name);
  if (shm.name.size() < 2 || shm.name.front() != '/')
    table.fail("name", "must begin with a slash: \"/odomd\", or a path");
  table.read_mode("mode", shm.mode);
  if ((shm.mode & ~0644U) != 0 || (shm.mode & 0600U) != 0600U)
    table.fail("mode", "must be 0o600, 0o640 or 0o644: clients refuse what others may write");
  table.read("group", shm.group);
  table.finish();
  return shm;
}

StatusConfig read_status(TableReader table) {
  StatusConfig status;
  table.read("socket", status.socket);
  table.read_mode("socket_mode", status.socket_mode);
  table.read("socket_group", status.socket_group);
  table.finish();
  return status;
}

RecordConfig read_record(TableReader table) {
  RecordConfig record;
  table.read("socket", record.socket);
  table.finish();
  return record;
}

LogConfig read_log(TableReader table) {
  LogConfig log;
  table.read("file", log.file);
  if (const auto level = table.read_choice("level", level_names)) log.level = level_names[*level];
  table.finish();
  return log;
}

/// The parameters of the full model that users tune; docs/model.md describes them.
void read_tuning(TableReader& table, estimator::Tuning& tuning) {
  const std::pair<std::string_view, double*> walks[] = {
      {"gyro_bias_walk", &tuning.gyro_bias_walk},
      {"gyro_scale_walk", &tuning.gyro_scale_walk},
      {"accel_bias_walk", &tuning.accel_bias_walk},
      {"wheel_scale_walk", &tuning.wheel_scale_walk},
      {"steering_offset_walk", &tuning.steering_offset_walk},
      {"stiffness_scale_walk", &tuning.stiffness_scale_walk},
  };
  for (const auto& [key, value] : walks)
    table.read(key, *value, {0.0, 1.0, false, "above 0, at most 1"});
  const std::pair<std::string_view, std::string_view> removed[] = {
      {"tyre_force_error",
       "use side_slip_error instead, the error of v_y per lateral acceleration"},
      {"yaw_moment_error", "use front_angle_error instead, an angle at the front wheels in rad"},
  };
  for (const auto& [key, instead] : removed)
    if (table.contains(key)) table.fail(key, fmt::format("was removed; {}", instead));
  table.read("front_angle_error", tuning.front_angle, {0.0, 1.0, false, "above 0, at most 1"});
  table.read("side_slip_error", tuning.side_slip, {0.0, 10.0, false, "above 0, at most 10"});
  table.read("wheel_radius_error", tuning.wheel_radius, {0.0, 0.5, true, "0 to 0.5"});
  table.read("wheel_slip", tuning.wheel_slip, {0.0, 1.0, false, "above 0, at most 1"});
}

void read_filter(TableReader table, Config& config) {
  if (table.has("model")) {
    std::string name;
    table.read("model", name);
    try {
      config.model = parse_model(name);
    } catch (const std::invalid_argument& error) {
      table.fail("model", error.what());
    }
  }
  table.read("window", config.window_s,
             {shortest_window_s, longest_window_s, true, "0.2 to 1 (s)"});
  table.read("camera_gate", config.camera_gate, {1.0, 1e6, true, "1 to 1e6"});
  read_tuning(table, config.tuning);
  table.read("paper_q", config.paper_noise.Q, positive);
  table.read("paper_r", config.paper_noise.R, positive);
  table.finish();
}

void read_imu(TableReader table, Config& config) {
  table.read("position", config.imu_position, any_number);
  table.read("yaw", config.imu_yaw, {-3.15, 3.15, true, "-3.15 to 3.15 (rad)"});
  for (auto& [key, value] :
       {std::pair<std::string_view, std::optional<double>*>{"roll_gradient", &config.roll_gradient},
        {"pitch_gradient", &config.pitch_gradient}}) {
    if (!table.has(key)) continue;
    table.read(key, value->emplace(), {-0.5, 0.5, true, "-0.5 to 0.5 (rad per g)"});
  }
  table.finish();
}

void read_reference(TableReader table, Config& config) {
  if (table.has("lever_arm"))
    table.read("lever_arm", config.reference_lever_arm.emplace(), any_number);
  table.finish();
}

void read_initial(TableReader table, Config& config) {
  std::array<double, 3> pose{};
  table.require("pose");
  table.read("pose", pose, any_number);
  table.finish();
  config.initial_pose = estimator::Pose2{pose[0], pose[1], pose[2]};
  if (!estimator::is_possible(*config.initial_pose)) table.fail("pose", std::string(pose_too_far));
}

}  // namespace

Config load_config(const std::filesystem::path& file) {
  return parse_config(read_toml_file(file), file);
}

Config parse_config(std::string text, const std::filesystem::path& file) {
  Config config;
  config.file = file;
  config.text = std::move(text);
  const toml::table parsed = parse_toml(config.text, file);
  TableReader root(parsed, "", file);

  if (auto table = root.table("vehicle", "[vehicle]")) {
    config.vehicle = read_vehicle(*table);
  } else {
    config.warnings.push_back(found(
        diagnostics::kind("reference_car"), file.string(),
        fmt::format("no [vehicle]: using the reference car (1:10, {} kg)", config.vehicle.mass)));
  }
  root.require("can", "; name the database and the signals in [can]");
  auto can = root.table("can", "[can]");
  config.can = read_can(*can);
  if (auto table = root.table("camera", "[camera]")) config.camera = read_camera(*table);
  if (auto table = root.table("reference", "[reference]")) read_reference(*table, config);
  if (auto table = root.table("steering", "[steering]"))
    config.vehicle.steering = read_steering(*table);
  if (auto table = root.table("imu", "[imu]")) read_imu(*table, config);
  if (auto table = root.table("initial", "[initial]")) read_initial(*table, config);
  if (auto table = root.table("filter", "[filter]")) read_filter(*table, config);
  if (auto table = root.table("realtime", "[realtime]")) config.realtime = read_realtime(*table);
  if (auto table = root.table("shm", "[shm]")) config.shm = read_shm(*table);
  if (auto table = root.table("status", "[status]")) config.status = read_status(*table);
  if (auto table = root.table("record", "[record]")) config.record = read_record(*table);
  if (auto table = root.table("log", "[log]")) config.log = read_log(*table);
  root.finish();
  return config;
}

void place_sockets(Config& config, const std::filesystem::path& directory) {
  if (config.camera.socket.empty()) config.camera.socket = directory / "camera.sock";
  if (config.status.socket.empty()) config.status.socket = directory / "status.sock";
}

std::filesystem::path record_socket(const Config& config) {
  return config.record.socket.empty() ? config.status.socket.parent_path() / "record.sock"
                                      : config.record.socket;
}

std::uint32_t record_mode(const Config& config) {
  return config.shm.mode | (config.shm.mode & 0444U) >> 1U;  // connecting needs write permission
}

}  // namespace odomd::daemon
