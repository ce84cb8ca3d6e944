#include "tools/drive_files/camera_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "tools/cli/files.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/drive_files/table.hpp"

namespace odomd::tools {

using diagnostics::found;

CsvReader camera_reader(std::istream& input, const std::string& name) {
  return {input, name, names_of<estimator::CameraPose>(camera_columns), LastLine::drop_unended};
}

std::optional<estimator::CameraPose> next_camera_pose(CsvReader& reader) {
  if (!reader.next()) return std::nullopt;
  const auto pose = read_row<estimator::CameraPose>(reader, camera_columns);
  std::size_t column = 5;
  for (const double sigma : {pose.sigma_x, pose.sigma_y, pose.sigma_yaw}) {
    if (!(sigma > 0.0))
      reader.fail(column, "a standard deviation must be above 0; correct or remove the line");
    ++column;
  }
  return pose;
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
