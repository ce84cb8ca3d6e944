#include "tools/drive_files/pose_fields.hpp"

#include <array>
#include <cmath>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

using P = const odom_pose&;
using D = const odom_details&;

double sigma(double variance) {
  return std::sqrt(variance > 0.0 ? variance : 0.0);
}
double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

// Covariances: odom_pose has xx, xy, xyaw, yy, yyaw, yawyaw; odom_details the variances of vx, vy
// and yaw_rate at 9, 12 and 14.
constexpr std::array fields{
    PoseField{"tick", "tick", [](P p, D) { return static_cast<double>(p.tick); }, true},
    PoseField{"map/x", "x", [](P p, D) { return p.x; }},
    PoseField{"map/y", "y", [](P p, D) { return p.y; }},
    PoseField{"map/yaw", "yaw", [](P p, D) { return p.yaw; }},
    PoseField{"odom/x", "odom_x", [](P p, D) { return p.odom_x; }},
    PoseField{"odom/y", "odom_y", [](P p, D) { return p.odom_y; }},
    PoseField{"odom/yaw", "odom_yaw", [](P p, D) { return p.odom_yaw; }},
    PoseField{"velocity/x", "vx", [](P p, D) { return p.vx; }},
    PoseField{"velocity/y", "vy", [](P p, D) { return p.vy; }},
    PoseField{"velocity/yaw", "yaw_rate", [](P p, D) { return p.yaw_rate; }},
    PoseField{"velocity_dot/x", "", [](P p, D) { return p.vx_dot; }},
    PoseField{"velocity_dot/y", "", [](P p, D) { return p.vy_dot; }},
    PoseField{"velocity_dot/yaw", "", [](P p, D) { return p.yaw_accel; }},
    PoseField{"accel/x", "accel_x", [](P p, D) { return p.accel_x; }},
    PoseField{"accel/y", "accel_y", [](P p, D) { return p.accel_y; }},
    PoseField{"steering", "steering", [](P p, D) { return p.steering; }},
    PoseField{"sigma/x", "sigma_x", [](P p, D) { return sigma(p.covariance[0]); }},
    PoseField{"sigma/y", "sigma_y", [](P p, D) { return sigma(p.covariance[3]); }},
    PoseField{"sigma/yaw", "sigma_yaw", [](P p, D) { return sigma(p.covariance[5]); }},
    PoseField{"covariance/xy", "cov_xy", [](P p, D) { return p.covariance[1]; }},
    PoseField{"covariance/xyaw", "cov_xyaw", [](P p, D) { return p.covariance[2]; }},
    PoseField{"covariance/yyaw", "cov_yyaw", [](P p, D) { return p.covariance[4]; }},
    PoseField{"velocity_sigma/x", "", [](P, D d) { return sigma(d.velocity_covariance[9]); }},
    PoseField{"velocity_sigma/y", "", [](P, D d) { return sigma(d.velocity_covariance[12]); }},
    PoseField{"velocity_sigma/yaw", "", [](P, D d) { return sigma(d.velocity_covariance[14]); }},
    PoseField{mode_path, "mode", [](P p, D) { return static_cast<double>(p.mode); }},
    PoseField{"conditions", "conditions", [](P p, D) { return static_cast<double>(p.conditions); },
              true},
    PoseField{"health", "", [](P p, D) { return static_cast<double>(p.health); }},
    PoseField{"reset_count", "reset_count",
              [](P p, D) { return static_cast<double>(p.reset_count); }, true},
    PoseField{"jump/x", "", [](P p, D) { return p.jump_x; }},
    PoseField{"jump/y", "", [](P p, D) { return p.jump_y; }},
    PoseField{"jump/yaw", "", [](P p, D) { return p.jump_yaw; }},
    PoseField{"calibration/gyro_bias", "gyro_bias", [](P, D d) { return d.gyro_bias; }},
    PoseField{"calibration/gyro_scale", "gyro_scale", [](P, D d) { return d.gyro_scale; }},
    PoseField{"calibration/accel_bias_x", "accel_bias_x", [](P, D d) { return d.accel_bias_x; }},
    PoseField{"calibration/accel_bias_y", "accel_bias_y", [](P, D d) { return d.accel_bias_y; }},
    PoseField{"calibration/wheel_scale", "wheel_scale", [](P, D d) { return d.wheel_scale; }},
    PoseField{"calibration/steering_offset", "steering_offset",
              [](P, D d) { return d.steering_offset; }},
    PoseField{"calibration/stiffness_scale", "stiffness_scale",
              [](P, D d) { return d.stiffness_scale; }},
    PoseField{"calibration/gyro_latency", "gyro_latency", [](P, D d) { return d.gyro_latency; }},
    PoseField{"calibration/wheel_latency", "wheel_latency", [](P, D d) { return d.wheel_latency; }},
    PoseField{"calibration/steering_latency", "steering_latency",
              [](P, D d) { return d.steering_latency; }},
    PoseField{"calibration/grip", "grip", [](P, D d) { return d.grip; }},
    PoseField{"beat/wakeup_latency", "", [](P, D d) { return seconds(d.wakeup_latency_ns); }},
    PoseField{"beat/execution", "", [](P, D d) { return seconds(d.execution_ns); }},
};

// Escapes a text for JSON. Control characters become blanks: names and roles have none.
void append_escaped(std::string& out, std::string_view text) {
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
}

}  // namespace

std::span<const PoseField> pose_fields() {
  return fields;
}

NestedJson::NestedJson(std::string& out) : out_(out) {
  out_ += '{';
}

void NestedJson::name(std::string_view path) {
  const std::size_t slash = path.find('/');
  const std::string_view group = slash == std::string_view::npos ? "" : path.substr(0, slash);
  const std::string_view leaf = slash == std::string_view::npos ? path : path.substr(slash + 1);
  if (group != group_) {
    if (!group_.empty()) out_ += '}';
    if (!group.empty()) {
      out_ += first_ ? "\"" : ",\"";
      out_.append(group).append("\":{");
      first_ = true;
    }
    group_ = group;
  }
  out_ += first_ ? "\"" : ",\"";
  out_.append(leaf).append("\":");
  first_ = false;
}

void NestedJson::number(std::string_view path, double value) {
  name(path);
  if (std::isfinite(value)) {
    append_number(out_, value);
  } else {
    out_ += "null";
  }
}

void NestedJson::text(std::string_view path, std::string_view value) {
  name(path);
  out_ += '"';
  append_escaped(out_, value);
  out_ += '"';
}

void NestedJson::raw(std::string_view path, std::string_view json) {
  name(path);
  out_ += json;
}

void NestedJson::end() {
  if (!group_.empty()) out_ += '}';
  out_ += '}';
}

}  // namespace odomd::tools
