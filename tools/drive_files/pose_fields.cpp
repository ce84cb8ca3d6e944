#include "tools/drive_files/pose_fields.hpp"

#include <array>
#include <cmath>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

using Pose = odom_pose;
using Details = odom_details;

double sigma(double variance) {
  return std::sqrt(variance > 0.0 ? variance : 0.0);
}
double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

// Covariances: odom_pose has xx, xy, xyaw, yy, yyaw, yawyaw; odom_details the variances of vx, vy
// and yaw_rate at 9, 12 and 14.
constexpr std::array fields{
    PoseField{"tick", "tick",
              [](const Pose& p, const Details&) { return static_cast<double>(p.tick); }},
    PoseField{"map/x", "x", [](const Pose& p, const Details&) { return p.x; }},
    PoseField{"map/y", "y", [](const Pose& p, const Details&) { return p.y; }},
    PoseField{"map/yaw", "yaw", [](const Pose& p, const Details&) { return p.yaw; }},
    PoseField{"odom/x", "odom_x", [](const Pose& p, const Details&) { return p.odom_x; }},
    PoseField{"odom/y", "odom_y", [](const Pose& p, const Details&) { return p.odom_y; }},
    PoseField{"odom/yaw", "odom_yaw", [](const Pose& p, const Details&) { return p.odom_yaw; }},
    PoseField{"velocity/x", "vx", [](const Pose& p, const Details&) { return p.vx; }},
    PoseField{"velocity/y", "vy", [](const Pose& p, const Details&) { return p.vy; }},
    PoseField{"velocity/yaw", "yaw_rate", [](const Pose& p, const Details&) { return p.yaw_rate; }},
    PoseField{"velocity_dot/x", "", [](const Pose& p, const Details&) { return p.vx_dot; }},
    PoseField{"velocity_dot/y", "", [](const Pose& p, const Details&) { return p.vy_dot; }},
    PoseField{"velocity_dot/yaw", "", [](const Pose& p, const Details&) { return p.yaw_accel; }},
    PoseField{"accel/x", "accel_x", [](const Pose& p, const Details&) { return p.accel_x; }},
    PoseField{"accel/y", "accel_y", [](const Pose& p, const Details&) { return p.accel_y; }},
    PoseField{"steering", "steering", [](const Pose& p, const Details&) { return p.steering; }},
    PoseField{"sigma/x", "sigma_x",
              [](const Pose& p, const Details&) { return sigma(p.covariance[0]); }},
    PoseField{"sigma/y", "sigma_y",
              [](const Pose& p, const Details&) { return sigma(p.covariance[3]); }},
    PoseField{"sigma/yaw", "sigma_yaw",
              [](const Pose& p, const Details&) { return sigma(p.covariance[5]); }},
    PoseField{"covariance/xy", "cov_xy",
              [](const Pose& p, const Details&) { return p.covariance[1]; }},
    PoseField{"covariance/xyaw", "cov_xyaw",
              [](const Pose& p, const Details&) { return p.covariance[2]; }},
    PoseField{"covariance/yyaw", "cov_yyaw",
              [](const Pose& p, const Details&) { return p.covariance[4]; }},
    PoseField{"velocity_sigma/x", "",
              [](const Pose&, const Details& d) { return sigma(d.velocity_covariance[9]); }},
    PoseField{"velocity_sigma/y", "",
              [](const Pose&, const Details& d) { return sigma(d.velocity_covariance[12]); }},
    PoseField{"velocity_sigma/yaw", "",
              [](const Pose&, const Details& d) { return sigma(d.velocity_covariance[14]); }},
    PoseField{mode_path, "mode",
              [](const Pose& p, const Details&) { return static_cast<double>(p.mode); }},
    PoseField{"conditions", "conditions",
              [](const Pose& p, const Details&) { return static_cast<double>(p.conditions); }},
    PoseField{"health", "",
              [](const Pose& p, const Details&) { return static_cast<double>(p.health); }},
    PoseField{"reset_count", "reset_count",
              [](const Pose& p, const Details&) { return static_cast<double>(p.reset_count); }},
    PoseField{"jump/x", "", [](const Pose& p, const Details&) { return p.jump_x; }},
    PoseField{"jump/y", "", [](const Pose& p, const Details&) { return p.jump_y; }},
    PoseField{"jump/yaw", "", [](const Pose& p, const Details&) { return p.jump_yaw; }},
    PoseField{"calibration/gyro_bias", "gyro_bias",
              [](const Pose&, const Details& d) { return d.gyro_bias; }},
    PoseField{"calibration/gyro_scale", "gyro_scale",
              [](const Pose&, const Details& d) { return d.gyro_scale; }},
    PoseField{"calibration/accel_bias_x", "accel_bias_x",
              [](const Pose&, const Details& d) { return d.accel_bias_x; }},
    PoseField{"calibration/accel_bias_y", "accel_bias_y",
              [](const Pose&, const Details& d) { return d.accel_bias_y; }},
    PoseField{"calibration/wheel_scale", "wheel_scale",
              [](const Pose&, const Details& d) { return d.wheel_scale; }},
    PoseField{"calibration/steering_offset", "steering_offset",
              [](const Pose&, const Details& d) { return d.steering_offset; }},
    PoseField{"calibration/stiffness_scale", "stiffness_scale",
              [](const Pose&, const Details& d) { return d.stiffness_scale; }},
    PoseField{"calibration/gyro_latency", "gyro_latency",
              [](const Pose&, const Details& d) { return d.gyro_latency; }},
    PoseField{"calibration/wheel_latency", "wheel_latency",
              [](const Pose&, const Details& d) { return d.wheel_latency; }},
    PoseField{"calibration/steering_latency", "steering_latency",
              [](const Pose&, const Details& d) { return d.steering_latency; }},
    PoseField{"calibration/grip", "grip", [](const Pose&, const Details& d) { return d.grip; }},
    PoseField{"beat/wakeup_latency", "",
              [](const Pose&, const Details& d) { return seconds(d.wakeup_latency_ns); }},
    PoseField{"beat/execution", "",
              [](const Pose&, const Details& d) { return seconds(d.execution_ns); }},
};

// Characters that need no escaping in JSON: our names and roles use no others.
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
