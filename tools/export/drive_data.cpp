#include "tools/export/drive_data.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <stdexcept>

#include "can_protocol/decode/decoder.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/drive_files/recording_folder.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/recording.hpp"
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

/// The logs of a drive, and all that is needed to decode them.
struct FrameSource {
  daemon::Config config;
  std::vector<can::Database> databases;
  std::vector<std::string> bus_names;  ///< known before a log is read
  std::vector<std::string> logs;
  can::Damage damage = can::Damage::left_out;
};

std::optional<FrameSource> frame_source(const ExportSources& sources, DriveData& data) {
  FrameSource source{.damage = sources.damage};
  if (!sources.recording.empty()) {
    Recording recording = open_recording(sources.recording);
    append(data.warnings, recording.warnings);
    source.config = std::move(recording.config);
    source.databases = std::move(recording.databases);
    source.bus_names = recording.buses;
    const fs::path frames = sources.recording / recorded_frames;
    // The recording of a silent bus has an empty file.
    if (fs::exists(frames) && fs::file_size(frames) > 0) source.logs = {frames.string()};
    return source;
  }
  if (sources.logs.empty()) return std::nullopt;
  if (sources.config.empty()) {
    data.warnings.push_back(
        found(diagnostics::kind("log_content"), sources.logs.front(),
              "left out: without a configuration (--config) its frames cannot be decoded"));
    return std::nullopt;
  }
  source.config = daemon::load_config(sources.config);
  if (!sources.databases.empty())
    source.config.can.dbc.assign(sources.databases.begin(), sources.databases.end());
  source.databases = daemon::load_databases(source.config, data.warnings);
  source.bus_names = daemon::expected_buses(source.config);
  source.logs = sources.logs;
  return source;
}

/// Reads the frames, keeps their signals, and replays them for poses if there are none.
class FramePass {
 public:
  FramePass(const FrameSource& source, DriveData& data) : source_(source), data_(data) {
    for (const std::string& name : source.bus_names) buses_.index_of(name);
  }

  void run() {
    can::MergedLog log =
        open_mapped_log(source_.config, source_.databases, source_.logs, buses_, source_.damage);
    can::Decoder decoder(source_.databases, source_.config.can.bindings,
                         source_.config.can.protections, buses_.all());
    const auto next = [&] {
      const can::Frame* const frame = log.next();
      if (frame != nullptr) keep_signals(decoder, *frame);
      return frame;
    };
    if (data_.poses.fields.empty()) {
      replay_by(next, log);
    } else {
      while (next() != nullptr) continue;
    }
    append(data_.warnings, diagnostics::kind("log_content"), log.warnings());
    std::ranges::stable_sort(data_.signals, {}, &SignalSample::frame_ns);
  }

 private:
  void keep_signals(can::Decoder& decoder, const can::Frame& frame) {
    if (frame.time_ns == 0) return;  // has no stamp
    const can::DecodeResult result = decoder.decode(frame, samples_);
    for (std::size_t i = 0; i < result.count; ++i)
      data_.signals.push_back({frame.time_ns, samples_[i].time_ns,
                               static_cast<estimator::Source>(samples_[i].channel),
                               samples_[i].value});
  }

  void replay_by(const NextFrame& next, const can::MergedLog& log) try {
    for (const PoseField& field : pose_fields())  // a replay has no beat
      if (!field.path.starts_with("beat/")) data_.poses.fields.push_back(&field);
    const auto pipeline = std::make_unique<daemon::Pipeline>(source_.config, source_.databases,
                                                             buses_.all(), !data_.camera.empty());
    replay(*pipeline, source_.config.realtime.period_ns, next, data_.camera,
           [this](const daemon::TickRecord& record) {
             data_.poses.times_ns.push_back(record.pose.time_ns);
             for (const PoseField* field : data_.poses.fields)
               data_.poses.values.push_back(field->value(record.pose, record.details));
           });
  } catch (const PauseError& error) {
    throw PauseError(log.position() + error.what());
  }

  const FrameSource& source_;
  DriveData& data_;
  can::BusNames buses_;
  std::array<can::Sample, can::max_samples_per_frame> samples_{};
};

}  // namespace

ExportSources sources_in(const fs::path& source) {
  ExportSources sources;
  if (!fs::is_directory(source)) {
    sources.pose = source;
    return sources;
  }
  const auto there = [&source](const char* name) {
    return fs::exists(source / name) ? source / name : fs::path{};
  };
  sources.pose = there(recorded_poses);
  sources.camera = there(recorded_cameras);
  if (!there(recorded_beat).empty() && !there(recorded_info).empty()) {
    sources.recording = source;
    return sources;
  }
  sources.config = there("car.toml");
  sources.truth = there("truth.csv");
  if (const auto log = log_in(source)) sources.logs = {log->string()};
  if (sources.pose.empty() && sources.logs.empty() && sources.truth.empty())
    throw std::invalid_argument(
        source.string() +
        ": contains neither a recording nor a drive (pose.csv, drive.log or "
        "can.log with car.toml, truth.csv)");
  return sources;
}

DriveData read_drive(const ExportSources& sources) {
  DriveData data;
  if (!sources.pose.empty()) data.poses = read_poses(sources.pose, data.warnings);
  if (!sources.camera.empty()) {
    CameraLog log = read_camera_log(sources.camera);
    data.camera = std::move(log.poses);
    append(data.warnings, log.warnings);
  }
  if (!sources.truth.empty()) {
    Trajectory truth = read_trajectory(sources.truth);
    data.truth = std::move(truth.points);
    data.truth_has_motion = truth.has_motion;
    append(data.warnings, truth.warnings);
  }
  if (const auto frames = frame_source(sources, data); frames && !frames->logs.empty())
    FramePass(*frames, data).run();
  return data;
}

}  // namespace odomd::tools
