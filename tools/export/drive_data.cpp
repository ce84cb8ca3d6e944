#include "tools/export/export.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/core/pipeline.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/recording_folder.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {
namespace {

namespace fs = std::filesystem;

PoseTable read_poses(const fs::path& file, diagnostics::Diagnostics& warnings) {
  std::vector<const PoseField*> known;
  std::vector<std::string> names{"t", "x", "y", "yaw"};
  const std::size_t required = names.size();
  for (const PoseField& field : pose_fields()) {
    if (field.column.empty()) continue;
    known.push_back(&field);
    names.emplace_back(field.column);
  }
  auto input = open_input(file);
  CsvReader reader(input, file.string(), names, LastLine::keep_whole, {.required = required});
  PoseTable table;
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (!reader.has(required + i)) continue;
    table.fields.push_back(known[i]);
    columns.push_back(required + i);
  }
  while (reader.next()) {
    const std::int64_t t_ns = reader.time_ns(0);
    if (!table.times_ns.empty() && t_ns < table.times_ns.back())
      reader.fail(0, "the time runs backwards; sort the rows, or export the drives one by one");
    table.times_ns.push_back(t_ns);
    for (std::size_t i = 0; i < columns.size(); ++i)
      table.values.push_back(table.fields[i]->path == mode_path
                                 ? static_cast<double>(reader.word(
                                       columns[i], estimator::mode_names, " is not a mode"))
                                 : reader.number(columns[i]));
  }
  if (table.times_ns.empty())
    warnings.push_back(found(diagnostics::kind("file_content"), file.string(), "contains no pose"));
  append(warnings, diagnostics::kind("file_content"), reader.warnings());
  return table;
}

PoseTable replayed_poses(const Drive& drive) {
  PoseTable table;
  for (const PoseField& field : pose_fields())  // a replay has no beat
    if (!field.path.starts_with("beat/")) table.fields.push_back(&field);
  const auto pipeline = std::make_unique<daemon::Pipeline>(drive.config, drive.databases,
                                                           drive.buses, !drive.cameras.empty());
  auto frame = drive.frames.begin();
  replay(
      *pipeline, drive.config.realtime.period_ns,
      [&] { return frame == drive.frames.end() ? nullptr : &*frame++; }, drive.cameras,
      [&table](const daemon::TickRecord& record) {
        table.times_ns.push_back(record.pose.time_ns);
        for (const PoseField* field : table.fields)
          table.values.push_back(field->value(record.pose, record.details));
      });
  return table;
}

std::vector<SignalSample> signals_of(const Drive& drive) {
  can::Decoder decoder(drive.databases, drive.config.can.bindings, drive.config.can.protections,
                       drive.buses);
  std::array<can::Sample, can::max_samples_per_frame> samples{};
  std::vector<SignalSample> signals;
  for (const can::Frame& frame : drive.frames) {
    if (frame.time_ns == 0) continue;  // has no stamp
    const can::DecodeResult result = decoder.decode(frame, samples);
    for (const can::Sample& sample : std::span(samples).first(result.count))
      signals.push_back({frame.time_ns, sample.time_ns,
                         static_cast<estimator::Source>(sample.channel), sample.value});
  }
  std::ranges::stable_sort(signals, {}, &SignalSample::frame_ns);
  return signals;
}

// Neither the recording of a silent bus nor a folder with only poses has frames.
bool has_frames(const fs::path& folder) {
  const auto log = log_in(folder);
  return log && !fs::is_empty(*log);
}

}  // namespace

DriveData read_drive(const ExportSource& source) {
  DriveData data;
  const bool is_folder = fs::is_directory(source.drive);
  fs::path pose = source.pose;
  if (pose.empty()) pose = is_folder ? source.drive / recorded_poses : source.drive;
  if (!is_folder || !source.pose.empty() || fs::exists(pose))
    data.poses = read_poses(pose, data.warnings);
  if (!is_folder) return data;
  if (!data.poses.fields.empty() && !has_frames(source.drive)) {
    if (const fs::path file = source.drive / recorded_cameras; fs::exists(file)) {
      CameraLog camera = read_camera_log(file);
      data.camera = std::move(camera.poses);
      append(data.warnings, camera.warnings);
    }
    if (const fs::path file = source.drive / "truth.csv"; fs::exists(file)) {
      data.truth = read_trajectory(file);
      append(data.warnings, data.truth->warnings);
    }
    return data;
  }

  Drive drive =
      read_drive({.folder = source.drive, .config = source.config, .damage = source.damage});
  append(data.warnings, drive.warnings);
  data.signals = signals_of(drive);
  if (data.poses.fields.empty()) data.poses = replayed_poses(drive);
  data.camera = std::move(drive.cameras);
  data.truth = std::move(drive.reference);
  return data;
}

}  // namespace odomd::tools
