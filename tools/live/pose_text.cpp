#include "tools/live/status_text.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "tools/cli/csv.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/conditions.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/live/status_value.hpp"

namespace odomd::tools {
namespace {

double sigma(const odom_pose& pose, std::size_t diagonal) {
  return std::sqrt(std::max(0.0, pose.covariance[diagonal]));
}

}  // namespace

std::string pose_as_text(const odom_pose& pose, std::int64_t age_ns) {
  std::string text = "mode   " + mode_name(pose.mode) + '\n';
  for (const Condition& condition : conditions_in(pose.conditions))
    text += fmt::format("       {}: {}\n", condition.name, condition.meaning);
  for (const auto& [name, value, unit, decimals, deviation] :
       {std::tuple{"x", pose.x, "m", 4, sigma(pose, 0)},
        {"y", pose.y, "m", 4, sigma(pose, 3)},
        {"yaw", heading(pose.yaw), "deg", 3, degrees * sigma(pose, 5)}})
    text += fmt::format("{:<6}{:>12} {:<3}  ± {}\n", name, fixed(value, decimals), unit,
                        fixed(deviation, decimals));
  return text + fmt::format(
                    "speed {:>12} m/s forward, {} m/s to the left, {} deg/s\n"
                    "tick  {:>12}, {} ms old, {}\n",
                    fixed(pose.vx, 4), fixed(pose.vy, 4), fixed(degrees * pose.yaw_rate, 2),
                    pose.tick, fixed(1e-6 * static_cast<double>(age_ns), 1),
                    counted(pose.reset_count, "reset"));
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
  std::string time;
  append_seconds(time, t_ns);
  return fmt::format("{:>20}  x {:>9}  y {:>9}  yaw {:>7} deg  v {:>6} m/s  {}\n", time,
                     fixed(pose.x, 3), fixed(pose.y, 3), fixed(heading(pose.yaw), 1),
                     fixed(pose.vx, 2), mode_name(pose.mode));
}

}  // namespace odomd::tools
