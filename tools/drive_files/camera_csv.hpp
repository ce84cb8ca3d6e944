// Camera logs: t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw, on the clock of the CAN log.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {

inline constexpr auto camera_columns = [](auto&& cell, auto& pose) {
  cell("t_arrival", pose.arrival_ns);
  cell("t_capture", pose.capture_ns);
  cell("x", pose.x);
  cell("y", pose.y);
  cell("yaw", pose.yaw);
  cell("sigma_x", pose.sigma_x);
  cell("sigma_y", pose.sigma_y);
  cell("sigma_yaw", pose.sigma_yaw);
};

struct CameraLog {
  /// In order of arrival; poses of the camera's reference point, not of the centre of gravity.
  std::vector<estimator::CameraPose> poses;
  diagnostics::Diagnostics warnings;
};

/// Reads a whole log. Throws std::invalid_argument with file, line and column if it is not usable:
/// a missing column, a field that is not a finite number, a sigma that is not positive. A last line
/// that is cut off, rows out of the order of arrival, and poses that arrive before their capture
/// give warnings.
[[nodiscard]] CameraLog read_camera_log(const std::filesystem::path& file);

/// The warning about a log without a single pose.
[[nodiscard]] diagnostics::Diagnostic no_camera_pose(const std::filesystem::path& file);

/// A reader for the camera's columns. next_camera_pose() reads a row; returns nothing at the end.
[[nodiscard]] CsvReader camera_reader(std::istream& input, const std::string& name);
[[nodiscard]] std::optional<estimator::CameraPose> next_camera_pose(CsvReader& reader);

}  // namespace odomd::tools
