#include "tools/live/pose_text.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tools/cli/csv.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/conditions.hpp"
#include "tools/drive_files/pose_csv.hpp"

namespace odomd::tools {
namespace {

double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
}

// Without the whole turns that the pose counts [deg].
double heading(const odom_pose& pose) {
  return degrees(std::remainder(pose.yaw, 2.0 * std::numbers::pi));
}

double sigma(const odom_pose& pose, std::size_t diagonal) {
  return std::sqrt(std::max(0.0, pose.covariance[diagonal]));
}

std::string padded(std::string text, std::size_t length) {
  if (text.size() < length) text.insert(0, length - text.size(), ' ');
  return text;
}

}  // namespace

std::string pose_as_text(const odom_pose& pose, std::int64_t age_ns) {
  const auto row = [](const std::string& name, const std::string& value, const std::string& unit,
                      const std::string& deviation) {
    return name + padded(value, 12) + ' ' + unit + "  ± " + deviation + '\n';
  };
  std::string text = "mode   " + mode_name(pose.mode) + '\n';
  for (const Condition& condition : conditions_in(pose.conditions)) {
    text += "       " + std::string{condition.name} + ": " + std::string{condition.meaning} + '\n';
  }
  text += row("x     ", fixed(pose.x, 4), "m  ", fixed(sigma(pose, 0), 4));
  text += row("y     ", fixed(pose.y, 4), "m  ", fixed(sigma(pose, 3), 4));
  text += row("yaw   ", fixed(heading(pose), 3), "deg", fixed(degrees(sigma(pose, 5)), 3));
  text += "speed " + padded(fixed(pose.vx, 4), 12) + " m/s forward, " + fixed(pose.vy, 4) +
          " m/s to the left, " + fixed(degrees(pose.yaw_rate), 2) + " deg/s\n";
  text += "tick  " + padded(std::to_string(pose.tick), 12) + ", " +
          fixed(static_cast<double>(age_ns) * 1e-6, 1) + " ms old, " +
          counted(pose.reset_count, "reset") + '\n';
  return text;
}

std::string pose_as_json(const odom_pose& pose, std::int64_t age_ns, const std::string& clock,
                         std::int64_t t_ns, bool fresh) {
  nlohmann::ordered_json conditions = nlohmann::ordered_json::array();
  for (const Condition& condition : conditions_in(pose.conditions)) {
    conditions.push_back(condition.name);
  }
  const nlohmann::ordered_json json{{"fresh", fresh},
                                    {"tick", pose.tick},
                                    {"clock", clock},
                                    {"time_ns", t_ns},
                                    {"age_s", static_cast<double>(age_ns) / 1e9},
                                    {"mode", mode_name(pose.mode)},
                                    {"conditions", conditions},
                                    {"x", pose.x},
                                    {"y", pose.y},
                                    {"yaw", pose.yaw},
                                    {"sigma_x", sigma(pose, 0)},
                                    {"sigma_y", sigma(pose, 3)},
                                    {"sigma_yaw", sigma(pose, 5)},
                                    {"odom_x", pose.odom_x},
                                    {"odom_y", pose.odom_y},
                                    {"odom_yaw", pose.odom_yaw},
                                    {"vx", pose.vx},
                                    {"vy", pose.vy},
                                    {"yaw_rate", pose.yaw_rate},
                                    {"steering", pose.steering},
                                    {"accel_x", pose.accel_x},
                                    {"accel_y", pose.accel_y},
                                    {"reset_count", pose.reset_count},
                                    {"last_jump", {pose.jump_x, pose.jump_y, pose.jump_yaw}}};
  return json.dump(2) + '\n';
}

std::string pose_as_line(const odom_pose& pose, std::int64_t t_ns) {
  std::string line;
  append_seconds(line, t_ns);
  return padded(line, 20) + "  x " + padded(fixed(pose.x, 3), 9) + "  y " +
         padded(fixed(pose.y, 3), 9) + "  yaw " + padded(fixed(heading(pose), 1), 7) + " deg  v " +
         padded(fixed(pose.vx, 2), 6) + " m/s  " + mode_name(pose.mode) + '\n';
}

}  // namespace odomd::tools
