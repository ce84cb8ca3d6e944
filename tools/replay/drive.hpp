// A drive in memory: a folder of `odom sim` or `odom record`, or one with the same files, read once
// and replayed any number of times.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// What to do with an existing camera.csv.
enum class CameraUse : std::uint8_t {
  take,       ///< use its poses at their times of arrival
  leave_out,  ///< dead reckoning
};

struct DriveFiles {
  std::filesystem::path folder;
  std::filesystem::path config;  ///< instead of the folder's car.toml; a database that is not at
                                 ///< its path is taken from the folder
  std::vector<std::filesystem::path> dbc;  ///< instead of the configuration's databases
  std::filesystem::path reference;         ///< instead of the folder's truth.csv
  CameraUse camera = CameraUse::take;
  can::Damage damage = can::Damage::left_out;
};

/// Everything that a replay needs; a replay does not change it.
struct Drive {
  std::string name;  ///< of the folder
  std::filesystem::path folder;
  daemon::Config config;  ///< with the timeouts from the databases
  std::vector<can::Database> databases;
  std::vector<std::string> buses;                       ///< index: Frame::bus
  std::vector<can::Frame> frames;                       ///< in the order in which ticks use them
  std::vector<can::Frame> unmapped;                     ///< of no mapped message
  std::vector<estimator::CameraPose> cameras;           ///< for the replay
  std::vector<estimator::CameraPose> cameras_left_out;  ///< with CameraUse::leave_out
  std::optional<Trajectory> reference;                  ///< as in the file
  bool closed_loop = false;  ///< without a reference: the drive ends where it began
  diagnostics::Diagnostics warnings;
};

/// The log of a drive's folder: drive.log (odom sim), otherwise can.log (odom record), if any.
[[nodiscard]] std::optional<std::filesystem::path> log_in(const std::filesystem::path& folder);

/// Names for several drives: the last part of each folder, or the whole path if that is not unique.
[[nodiscard]] std::vector<std::string> names_side_by_side(const std::vector<std::string>& folders);

/// The configuration of a drive, with its log as the source and, if it was recorded, its first
/// pose. Throws like read_drive.
[[nodiscard]] daemon::Config drive_config(const DriveFiles& files);

/// The files that a drive is read from, existing or not, which must not be overwritten. Throws like
/// read_drive if there is no configuration.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const DriveFiles& files);

/// Opens logs for the frames of mapped messages; other frames go to `unmapped`, if given. `buses`
/// numbers the configured buses first, then any other buses in the logs. Throws as can::MergedLog
/// does.
[[nodiscard]] can::MergedLog open_mapped_log(
    const daemon::Config& config, std::span<const can::Database> databases,
    std::span<const std::string> logs, can::BusNames& buses, can::Damage damage,
    const std::function<void(const can::Frame&)>& unmapped = {});

/// Reads car.toml, the databases that it names, drive.log or can.log, camera.csv and truth.csv; the
/// last two if they exist. Throws std::invalid_argument that names the file and the fix.
[[nodiscard]] Drive read_drive(const DriveFiles& files);

}  // namespace odomd::tools
