#include "tools/replay/drive.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <utility>

#include "base/input_file.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/diagnostics/log_order.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/recording_folder.hpp"
#include "tools/replay/recording.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

/// `name` in the folder, if it exists.
std::optional<fs::path> file_in(const fs::path& folder, const char* name) {
  std::error_code ignored;
  const fs::path file = folder / name;
  return fs::exists(file, ignored) ? std::optional(file) : std::nullopt;
}

/// "lap" for "drives/lap/", and for "." in that folder.
std::string name_of(const fs::path& folder) {
  std::error_code failed;
  const fs::path whole = fs::canonical(folder, failed);
  return failed || !whole.has_filename() ? folder.string() : whole.filename().string();
}

/// Replaces missing databases by those of the same name in the folder: a configuration outside the
/// folder may lack its databases.
void look_for_databases_in(const fs::path& folder, std::vector<fs::path>& databases) {
  std::error_code ignored;
  for (fs::path& database : databases)
    if (const fs::path own = folder / database.filename();
        !fs::exists(database, ignored) && fs::exists(own, ignored))
      database = fs::absolute(own);
}

daemon::Config config_of(const DriveFiles& files) {
  if (!files.config.empty()) {
    daemon::Config config = daemon::load_config(files.config);
    look_for_databases_in(files.folder, config.can.dbc);
    return config;
  }
  const auto own = file_in(files.folder, "car.toml");
  if (!own)
    throw std::invalid_argument(files.folder.string() +
                                ": has no car.toml; give the car's configuration with --config");
  return daemon::load_config(*own);
}

void check_folder(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_directory(folder, ignored)) return;
  const bool file = fs::exists(folder, ignored);
  throw std::invalid_argument(folder.string() + (file ? ": is a file; give the folder of its drive"
                                                      : ": is not a folder; check the path"));
}

void read_camera(Drive& drive, const fs::path& file, CameraUse use) try {
  CameraLog camera = read_camera_log(file);
  // Warnings are useless for poses that are neither used nor needed as a reference.
  if (use == CameraUse::take || !drive.reference) append(drive.warnings, camera.warnings);
  if (camera.poses.empty() && drive.config.camera.configured && use == CameraUse::take)
    drive.warnings.push_back(no_camera_pose(file));
  (use == CameraUse::take ? drive.cameras : drive.cameras_left_out) = std::move(camera.poses);
} catch (const std::invalid_argument& error) {
  if (use == CameraUse::take) throw;
  if (drive.reference) return;
  drive.warnings.push_back(found(diagnostics::kind("file_content"), {}, error.what()));
}

}  // namespace

std::optional<fs::path> log_in(const fs::path& folder) {
  for (const char* name : {"drive.log", "can.log"}) {
    const auto file = file_in(folder, name);
    if (!file) continue;
    if (const std::string_view kind = kind_of_no_file(*file); !kind.empty())
      throw std::invalid_argument(file->string() + ": is " + std::string(kind) +
                                  ", not a file; give a log that is no file with --can");
    return file;
  }
  return std::nullopt;
}

std::vector<std::string> names_side_by_side(const std::vector<std::string>& folders) {
  std::vector<std::string> names(folders.size());
  std::ranges::transform(folders, names.begin(), name_of);
  std::vector<std::string> several = names;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::ranges::count(names, names[i]) > 1) several[i] = folders[i];
  return several;
}

std::vector<fs::path> files_of(const DriveFiles& files) {
  check_folder(files.folder);
  std::vector<fs::path> all;
  if (!files.config.empty() || file_in(files.folder, "car.toml")) all = config_of(files).can.dbc;
  all.insert(all.end(), {files.config, files.reference});
  for (const char* name : {"car.toml", "car.dbc", "drive.log", "can.log", "camera.csv", "truth.csv",
                           "beat.csv", "pose.csv"})
    all.push_back(files.folder / name);
  return all;
}

can::MergedLog open_mapped_log(const daemon::Config& config,
                               std::span<const can::Database> databases,
                               std::span<const std::string> logs, can::BusNames& buses,
                               can::Damage damage,
                               const std::function<void(const can::Frame&)>& unmapped) {
  for (const std::string& bus : daemon::expected_buses(config))
    static_cast<void>(buses.index_of(bus));
  const auto decoder = std::make_shared<const can::Decoder>(databases, config.can.bindings,
                                                            config.can.protections, buses.all());
  const auto is_mapped = [decoder, unmapped](const can::Frame& frame) {
    const bool mapped = decoder->is_mapped(frame);
    if (!mapped && unmapped) unmapped(frame);
    return mapped;
  };
  return can::MergedLog(logs, buses, is_mapped, damage);
}

daemon::Config drive_config(const DriveFiles& files) {
  check_folder(files.folder);
  daemon::Config config = config_of(files);
  if (!files.dbc.empty()) config.can.dbc = files.dbc;
  const auto log = log_in(files.folder);
  if (!log)
    throw std::invalid_argument(
        files.folder.string() +
        ": has no drive.log and no can.log; give a folder of odom sim or odom record");
  config.can.sources = {log->string()};
  if (config.initial_pose && file_in(files.folder, recorded_info))
    begin_as_recorded(files.folder, config);
  return config;
}

Drive read_drive(const DriveFiles& files) {
  Drive drive;
  drive.folder = files.folder;
  drive.name = name_of(files.folder);
  drive.config = drive_config(files);
  drive.databases = daemon::load_databases(drive.config, drive.warnings);

  can::BusNames buses;
  can::MergedLog log =
      open_mapped_log(drive.config, drive.databases, drive.config.can.sources, buses, files.damage,
                      [&drive](const can::Frame& frame) { drive.unmapped.push_back(frame); });
  LogOrder order;
  while (const can::Frame* frame = log.next()) {
    order.take(frame->time_ns, [&log] { return log.position(); });
    drive.frames.push_back(*frame);
  }
  order.require_sorted();
  append(drive.warnings, diagnostics::kind("log_content"), log.warnings());
  drive.buses = buses.all();

  const auto reference =
      files.reference.empty() ? file_in(files.folder, "truth.csv") : std::optional(files.reference);
  if (reference) {
    drive.reference = read_trajectory(*reference);
    append(drive.warnings, drive.reference->warnings);
  }
  if (const auto file = file_in(files.folder, "camera.csv"))
    read_camera(drive, *file, files.camera);
  return drive;
}

}  // namespace odomd::tools
