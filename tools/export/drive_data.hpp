// Everything that can be exported from a drive: poses, camera, truth and signals, from files or a
// replay.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/camera_csv.hpp"
#include "tools/drive_files/pose_fields.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {

/// The files to export; empty: absent.
struct ExportSources {
  std::filesystem::path recording;  ///< a folder of odom record: configuration, frames
  std::filesystem::path pose;
  std::filesystem::path config;
  std::vector<std::string> logs;
  std::vector<std::string> databases;  ///< instead of the configuration's
  std::filesystem::path camera;
  std::filesystem::path truth;
  can::Damage damage = can::Damage::left_out;
};

/// The files of `source`: a pose file, a folder of odom record, or the folder of a drive
/// (drive.log, car.toml, camera.csv, truth.csv, pose.csv, if they exist). Throws
/// std::invalid_argument if it is none of these.
[[nodiscard]] ExportSources sources_in(const std::filesystem::path& source);

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
  std::vector<TrajectoryPoint> truth;
  bool truth_has_motion = false;
  std::vector<SignalSample> signals;
  diagnostics::Diagnostics warnings;
};

/// Reads everything. If there are frames and a configuration but no poses, the drive is replayed.
/// Throws std::invalid_argument for unusable files.
[[nodiscard]] DriveData read_drive(const ExportSources& sources);

}  // namespace odomd::tools
