// A drive in memory: a folder that `odom sim` or `odom record` has left, or one that is laid out
// likewise, read once to be replayed as often as one likes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "can_protocol/frame.hpp"
#include "daemon/core/config.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// What to do with a camera.csv that is there.
enum class CameraUse : std::uint8_t {
  take,       ///< its poses come in when they arrived
  leave_out,  ///< dead reckoning
};

struct DriveFiles {
  std::filesystem::path folder;
  std::filesystem::path config;     ///< instead of the folder's car.toml; its own car.dbc stays
  std::filesystem::path reference;  ///< instead of the folder's truth.csv
  CameraUse camera = CameraUse::take;
};

/// Whatever a replay needs; nothing in it changes by one.
struct Drive {
  std::string name;  ///< of the folder
  std::filesystem::path folder;
  daemon::Config config;  ///< with the time-outs that the databases give
  std::vector<can::Database> databases;
  std::vector<std::string> buses;  ///< as the frames are numbered
  std::vector<can::Frame> frames;  ///< in the order in which a tick takes them
  std::vector<estimator::CameraPose> cameras;
  std::optional<Trajectory> reference;  ///< as the file has it
  std::vector<std::string> warnings;
};

/// Throws std::invalid_argument where it is none.
void check_folder(const std::filesystem::path& folder);

/// The log of a drive's folder: its drive.log, as odom sim names it, else its can.log, as odom
/// record does; nothing where neither is there. need_log_in() throws std::invalid_argument then.
[[nodiscard]] std::optional<std::filesystem::path> log_in(const std::filesystem::path& folder);
[[nodiscard]] std::filesystem::path need_log_in(const std::filesystem::path& folder);

/// What several drives are called side by side: the last part of each folder; of those that have
/// it in common, the folder as it is given.
[[nodiscard]] std::vector<std::string> names_side_by_side(const std::vector<std::string>& folders);

/// The files that a drive is read from, there or not; for what must not be overwritten. Throws as
/// read_drive does where there is no configuration.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const DriveFiles& files);

/// Reads car.toml, the databases that it names, drive.log or can.log, camera.csv and truth.csv; the
/// last two where they are there. Throws std::invalid_argument that names the file and the mend.
[[nodiscard]] Drive read_drive(const DriveFiles& files);

}  // namespace odomd::tools
