#include "tools/drive_files/pose_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <ostream>
#include <ranges>
#include <string_view>

#include "estimator/common/estimate.hpp"
#include "tools/cli/csv.hpp"
#include "tools/drive_files/pose_fields.hpp"

namespace odomd::tools {
namespace {

constexpr std::string_view pose_columns =
    "t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode,"
    "tick,odom_x,odom_y,odom_yaw,reset_count,conditions,cov_xy,cov_xyaw,cov_yyaw,"
    "steering,accel_x,accel_y";

const std::vector<const PoseField*>& fields_after_time() {
  static const auto all = [] {
    std::vector<const PoseField*> found;
    for (const auto name : pose_columns | std::views::split(',') | std::views::drop(1))
      found.push_back(&*std::ranges::find(pose_fields(), std::string_view(name.begin(), name.end()),
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

constexpr std::size_t batch = 2048;  // rows: enough that starting a thread for them is cheap

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

PoseFile::PoseFile(std::ostream& out) : out_(out) {
  added_.reserve(batch);
  out_ << record_header();
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
