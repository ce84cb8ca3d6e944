#include "tools/drive_files/pose_csv.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ostream>
#include <span>
#include <string_view>

#include "estimator/common/estimate.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

constexpr std::string_view pose_columns =
    "t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode,"
    "tick,odom_x,odom_y,odom_yaw,reset_count,conditions,cov_xy,cov_xyaw,cov_yyaw,"
    "steering,accel_x,accel_y";

// Longer than 29 numbers of 25 characters, 11 of 11, a mode and three counts.
constexpr std::size_t longest_row = 1024;

double sigma_of(double variance) {
  return std::sqrt(variance > 0.0 ? variance : 0.0);
}

/// `further` columns follow those of the pose; of `sigmas` four digits are enough.
void append_row(std::string& out, const odom_pose& pose, std::int64_t t_ns,
                std::span<const double> further, std::span<const double> sigmas) {
  append_seconds(out, t_ns);
  // Written in place, one number after the other.
  const std::size_t begin = out.size();
  out.resize(begin + longest_row);
  char* end = out.data() + begin;
  char* const limit = end + longest_row;
  const auto number = [&](auto value) {
    *end++ = ',';
    end = std::to_chars(end, limit, value).ptr;
  };
  const auto numbers = [&](std::span<const double> values) {
    for (const double value : values) number(value);
  };
  const auto& P = pose.covariance;  // xx, xy, xyaw, yy, yyaw, yawyaw
  numbers(std::array{pose.x, pose.y, pose.yaw, pose.vx, pose.vy, pose.yaw_rate});
  numbers(std::array{sigma_of(P[0]), sigma_of(P[3]), sigma_of(P[5])});
  *end++ = ',';
  end = std::ranges::copy(mode_name(pose.mode), end).out;
  number(pose.tick);
  numbers(std::array{pose.odom_x, pose.odom_y, pose.odom_yaw});
  number(pose.reset_count);
  number(pose.conditions);
  numbers(std::array{P[1], P[2], P[4], pose.steering, pose.accel_x, pose.accel_y});
  numbers(further);
  for (const double sigma : sigmas) {
    *end++ = ',';
    end = std::to_chars(end, limit, sigma, std::chars_format::general, 4).ptr;
  }
  *end++ = '\n';
  out.resize(static_cast<std::size_t>(end - out.data()));
}

constexpr std::size_t batch = 2048;  // rows: enough that starting a thread for them is cheap

}  // namespace

void write_pose_header(std::ostream& out) {
  out << pose_columns << '\n';
}

void append_pose_row(std::string& out, const odom_pose& pose, std::int64_t t_ns) {
  append_row(out, pose, t_ns, {}, {});
}

void write_record_header(std::ostream& out) {
  out << pose_columns;
  for (const auto& [name, value] : daemon::calibrations) out << ',' << name;
  for (const auto& [name, value] : daemon::calibrations) out << ",sigma_" << name;
  out << '\n';
}

void append_record_row(std::string& out, const daemon::TickRecord& record, std::int64_t t_ns) {
  std::array<double, daemon::calibrations.size()> learnt{}, sigmas{};
  for (std::size_t i = 0; i < learnt.size(); ++i) {
    learnt[i] = record.details.*daemon::calibrations[i].value;
    sigmas[i] = daemon::calibration_sigma(record.details, i);
  }
  append_row(out, record.pose, t_ns, learnt, sigmas);
}

std::string mode_name(std::uint32_t mode) {
  return mode < estimator::mode_names.size() ? std::string{estimator::mode_names[mode]}
                                             : "mode " + std::to_string(mode);
}

PoseFile::PoseFile(std::ostream& out) : out_(out) {
  added_.reserve(batch);
  write_record_header(out_);
}

PoseFile::~PoseFile() = default;

void PoseFile::add(const daemon::TickRecord& record, std::int64_t t_ns) {
  added_.push_back({record, t_ns});
  if (added_.size() == batch) hand_over();
}

void PoseFile::finish() {
  hand_over();
  writing_.get();
}

void PoseFile::hand_over() {
  if (writing_.valid()) writing_.get();
  written_.swap(added_);
  added_.clear();
  writing_ = std::async([this] {
    text_.clear();
    for (const Row& row : written_) append_record_row(text_, row.record, row.t_ns);
    out_ << text_;
  });
}

}  // namespace odomd::tools
