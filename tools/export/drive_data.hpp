// Everything that can be exported from a drive: poses, camera, truth and signals, from files or a
// replay.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {

struct ExportSource {
  std::filesystem::path drive;   ///< a pose file, or a folder of odom sim, record or import
  std::filesystem::path pose;    ///< instead of the folder's pose.csv; empty: that one
  std::filesystem::path config;  ///< instead of the folder's car.toml; empty: that one
  can::Damage damage = can::Damage::left_out;
};

/// Rows of a pose file, with non-decreasing times and the fields that the file contains.
struct PoseTable {
  std::vector<const PoseField*> fields;
  std::vector<std::int64_t> times_ns;
  std::vector<double> values;  ///< row by row

  [[nodiscard]] std::span<const double> row(std::size_t i) const {
    return std::span(values).subspan(i * fields.size(), fields.size());
  }
};

struct SignalSample {
  std::int64_t frame_ns = 0;  ///< stamp of the frame
  std::int64_t time_ns = 0;   ///< when it was measured
  estimator::Source source = estimator::Source::yaw_rate;
  double value = 0.0;  ///< SI
};

struct DriveData {
  PoseTable poses;
  std::vector<estimator::CameraPose> camera;  ///< in order of arrival
  std::optional<Trajectory> truth;
  std::vector<SignalSample> signals;  ///< in order of frames
  diagnostics::Diagnostics warnings;
};

/// Reads everything. A folder without poses is replayed. Throws std::invalid_argument for unusable
/// files.
[[nodiscard]] DriveData read_drive(const ExportSource& source);

}  // namespace odomd::tools
