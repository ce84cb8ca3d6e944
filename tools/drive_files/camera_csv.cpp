#include "tools/drive_files/camera_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {

using diagnostics::found;
using diagnostics::kind;
namespace {

enum Column : std::size_t { t_arrival, t_capture, x, y, yaw, sigma_x, sigma_y, sigma_yaw };

double sigma_at(const CsvReader& reader, Column column) {
  const double sigma = reader.number(column);
  if (!(sigma > 0.0)) {
    reader.fail(column, "a standard deviation must be above 0; correct or remove the line");
  }
  return sigma;
}

}  // namespace

void append_camera_row(std::string& out, const estimator::CameraPose& pose) {
  append_seconds(out, pose.arrival_ns);
  out += ',';
  append_seconds(out, pose.capture_ns);
  for (const double value :
       {pose.x, pose.y, pose.yaw, pose.sigma_x, pose.sigma_y, pose.sigma_yaw}) {
    out += ',';
    append_number(out, value);
  }
  out += '\n';
}

CsvReader camera_reader(std::istream& input, const std::string& name) {
  return {input,
          name,
          {"t_arrival", "t_capture", "x", "y", "yaw", "sigma_x", "sigma_y", "sigma_yaw"},
          {},
          LastLine::drop_unended};
}

std::optional<estimator::CameraPose> next_camera_pose(CsvReader& reader) {
  if (!reader.next()) return std::nullopt;
  return estimator::CameraPose{.capture_ns = reader.time_ns(t_capture),
                               .arrival_ns = reader.time_ns(t_arrival),
                               .x = reader.number(x),
                               .y = reader.number(y),
                               .yaw = reader.number(yaw),
                               .sigma_x = sigma_at(reader, sigma_x),
                               .sigma_y = sigma_at(reader, sigma_y),
                               .sigma_yaw = sigma_at(reader, sigma_yaw)};
}

CameraLog read_camera_log(const std::filesystem::path& file) {
  auto input = open_input(file);
  CsvReader reader = camera_reader(input, file.string());
  CameraLog log;
  while (const auto pose = next_camera_pose(reader)) {
    log.poses.push_back(*pose);
  }
  append(log.warnings, kind("file_content"), reader.warnings());

  const auto before_seen = std::ranges::count_if(
      log.poses, [](const auto& pose) { return pose.arrival_ns < pose.capture_ns; });
  if (before_seen > 0)
    log.warnings.push_back(
        found(kind("camera_columns_exchanged"), file.string(),
              fmt::format("{} of {} poses arrive before they are captured and cannot be used",
                          before_seen, log.poses.size())));

  const auto by_arrival = [](const estimator::CameraPose& a, const estimator::CameraPose& b) {
    return a.arrival_ns < b.arrival_ns;
  };
  if (!std::is_sorted(log.poses.begin(), log.poses.end(), by_arrival)) {
    std::stable_sort(log.poses.begin(), log.poses.end(), by_arrival);
    log.warnings.push_back(found(kind("file_content"), file.string(),
                                 "rows were not in the order of t_arrival; sorted"));
  }
  return log;
}

diagnostics::Diagnostic no_camera_pose(const std::filesystem::path& file) {
  return found(kind("no_camera_pose"), file.string(), "contains no camera pose");
}

}  // namespace odomd::tools
