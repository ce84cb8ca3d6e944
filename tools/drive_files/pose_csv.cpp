#include "tools/drive_files/pose_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <ranges>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/seconds.hpp"
#include "estimator/common/estimate.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

using P = const odom_pose&;
using D = const odom_details&;

double sigma(double variance) {
  return std::sqrt(variance > 0.0 ? variance : 0.0);
}

// Covariances: odom_pose has xx, xy, xyaw, yy, yyaw, yawyaw; odom_details the variances of vx, vy
// and yaw_rate at 9, 12 and 14.
const std::vector<PoseField>& all_fields() {
  static const auto all = [] {
    std::vector<PoseField> fields{
        {"tick", "tick", [](P p, D) { return p.tick; }, true},
        {"map/x", "x", [](P p, D) { return p.x; }},
        {"map/y", "y", [](P p, D) { return p.y; }},
        {"map/yaw", "yaw", [](P p, D) { return p.yaw; }},
        {"odom/x", "odom_x", [](P p, D) { return p.odom_x; }},
        {"odom/y", "odom_y", [](P p, D) { return p.odom_y; }},
        {"odom/yaw", "odom_yaw", [](P p, D) { return p.odom_yaw; }},
        {"velocity/x", "vx", [](P p, D) { return p.vx; }},
        {"velocity/y", "vy", [](P p, D) { return p.vy; }},
        {"velocity/yaw", "yaw_rate", [](P p, D) { return p.yaw_rate; }},
        {"velocity_dot/x", "", [](P p, D) { return p.vx_dot; }},
        {"velocity_dot/y", "", [](P p, D) { return p.vy_dot; }},
        {"velocity_dot/yaw", "", [](P p, D) { return p.yaw_accel; }},
        {"accel/x", "accel_x", [](P p, D) { return p.accel_x; }},
        {"accel/y", "accel_y", [](P p, D) { return p.accel_y; }},
        {"steering", "steering", [](P p, D) { return p.steering; }},
        {"sigma/x", "sigma_x", [](P p, D) { return sigma(p.covariance[0]); }},
        {"sigma/y", "sigma_y", [](P p, D) { return sigma(p.covariance[3]); }},
        {"sigma/yaw", "sigma_yaw", [](P p, D) { return sigma(p.covariance[5]); }},
        {"covariance/xy", "cov_xy", [](P p, D) { return p.covariance[1]; }},
        {"covariance/xyaw", "cov_xyaw", [](P p, D) { return p.covariance[2]; }},
        {"covariance/yyaw", "cov_yyaw", [](P p, D) { return p.covariance[4]; }},
        {"velocity_sigma/x", "", [](P, D d) { return sigma(d.velocity_covariance[9]); }},
        {"velocity_sigma/y", "", [](P, D d) { return sigma(d.velocity_covariance[12]); }},
        {"velocity_sigma/yaw", "", [](P, D d) { return sigma(d.velocity_covariance[14]); }},
        {mode_path, "mode", [](P p, D) { return p.mode; }, true},
        {"conditions", "conditions", [](P p, D) { return p.conditions; }, true},
        {"health", "", [](P p, D) { return p.health; }, true},
        {"reset_count", "reset_count", [](P p, D) { return p.reset_count; }, true},
        {"jump/x", "", [](P p, D) { return p.jump_x; }},
        {"jump/y", "", [](P p, D) { return p.jump_y; }},
        {"jump/yaw", "", [](P p, D) { return p.jump_yaw; }},
    };
    for (const auto& [name, value] : daemon::calibrations)
      fields.push_back(
          {fmt::format("calibration/{}", name), name, [value](P, D d) { return d.*value; }});
    fields.push_back(
        {"beat/wakeup_latency", "", [](P, D d) { return seconds(d.wakeup_latency_ns); }});
    fields.push_back({"beat/execution", "", [](P, D d) { return seconds(d.execution_ns); }});
    return fields;
  }();
  return all;
}

constexpr std::string_view pose_columns =
    "t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode,"
    "tick,odom_x,odom_y,odom_yaw,reset_count,conditions,cov_xy,cov_xyaw,cov_yyaw,"
    "steering,accel_x,accel_y";

const std::vector<const PoseField*>& fields_after_time() {
  static const auto all = [] {
    std::vector<const PoseField*> found;
    for (const auto name : pose_columns | std::views::split(',') | std::views::drop(1))
      found.push_back(&*std::ranges::find(all_fields(), std::string_view(name.begin(), name.end()),
                                          &PoseField::column));
    return found;
  }();
  return all;
}

void append_row(std::string& out, const odom_pose& pose, const odom_details& details,
                std::int64_t t_ns) {
  append_seconds(out, t_ns);
  for (const PoseField* field : fields_after_time()) {
    out += ',';
    if (field->path == mode_path)
      out += mode_name(pose.mode);
    else if (field->is_count)
      fmt::format_to(std::back_inserter(out), "{}",
                     static_cast<std::uint64_t>(field->value(pose, details)));
    else
      append_number(out, field->value(pose, details));
  }
}

}  // namespace

std::string pose_header() {
  return fmt::format("{}\n", pose_columns);
}

void append_pose_row(std::string& out, const odom_pose& pose, std::int64_t t_ns) {
  append_row(out, pose, {}, t_ns);
  out += '\n';
}

std::string record_header() {
  std::string names(pose_columns);
  for (const auto& [name, value] : daemon::calibrations) names.append(",").append(name);
  for (const auto& [name, value] : daemon::calibrations) names.append(",sigma_").append(name);
  return names + '\n';
}

void append_record_row(std::string& out, const daemon::TickRecord& record, std::int64_t t_ns) {
  append_row(out, record.pose, record.details, t_ns);
  for (const auto& [name, value] : daemon::calibrations)
    append_number(out += ',', record.details.*value);
  for (std::size_t i = 0; i < daemon::calibrations.size(); ++i)  // four digits are enough
    fmt::format_to(std::back_inserter(out), ",{:.4g}",
                   daemon::calibration_sigma(record.details, i));
  out += '\n';
}

std::string mode_name(std::uint32_t mode) {
  return mode < estimator::mode_names.size() ? std::string{estimator::mode_names[mode]}
                                             : "mode " + std::to_string(mode);
}

std::span<const PoseField> pose_fields() {
  return all_fields();
}

void set_field(nlohmann::ordered_json& object, const PoseField& field, double value) {
  auto& member = object[nlohmann::ordered_json::json_pointer("/" + field.path)];
  if (field.is_count)
    member = static_cast<std::uint64_t>(value);
  else
    member = value;
  if (field.path == mode_path) object["mode_name"] = mode_name(static_cast<std::uint32_t>(value));
}

}  // namespace odomd::tools
