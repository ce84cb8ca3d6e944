#include "tools/replay/recording.hpp"

#include <array>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "can_protocol/sources/log_reader.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/core/recording_wire.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/text.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/recording_folder.hpp"
#include "tools/drive_files/table.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

std::vector<estimator::CameraPose> camera_poses(const Recording& recording,
                                                diagnostics::Diagnostics& warnings) {
  CameraLog log = read_camera_log(recording.folder / recorded_cameras);
  append(warnings, log.warnings);
  for (estimator::CameraPose& pose : log.poses) {
    pose.arrival_ns -= recording.clock_offset_ns;
    pose.capture_ns -= recording.clock_offset_ns;
  }
  return std::move(log.poses);
}

/// Feeds the drive from its files into a pipeline.
class RecordedDrive {
 public:
  RecordedDrive(const Recording& recording, can::BusNames& buses, daemon::Pipeline& pipeline,
                diagnostics::Diagnostics& warnings)
      : offset_ns_(recording.clock_offset_ns),
        pipeline_(pipeline),
        beat_file_(open_input(recording.folder / recorded_beat)),
        beat_(beat_file_, (recording.folder / recorded_beat).string(),
              names_of<BeatRow>(beat_columns), LastLine::drop_unended),
        cameras_(camera_poses(recording, warnings)) {
    const auto file = recording.folder / recorded_frames;
    static_cast<void>(open_input(file));
    // A silent bus leaves an empty file.
    if (std::filesystem::file_size(file) > 0)
      frames_.emplace(file.string(), buses, can::Damage::refused);  // beat.csv counts its frames
  }

  /// Reads the first row: the tick of the saved state, which has no inputs.
  [[nodiscard]] BeatRow begin() {
    if (!beat_.next())
      throw std::invalid_argument(beat_.place() + ": contains no tick; the recording is empty");
    return before_ = read_row<BeatRow>(beat_, beat_columns);
  }

  /// Runs the next tick; null at the end.
  const daemon::TickRecord* next(ReplaySummary& summary) {
    if (!beat_.next()) return nullptr;
    const auto row = read_row<BeatRow>(beat_, beat_columns);
    if (row.tick <= before_.tick) fail("the tick numbers do not increase");
    const std::int64_t woke_ns = row.woke_ns - offset_ns_;
    take_frames(row, woke_ns, summary);
    take_cameras(row, summary);
    pipeline_.set_conditions(row.conditions);
    before_ = row;
    return &pipeline_.tick(row.tick, row.time_ns - offset_ns_);
  }

  [[nodiscard]] const BeatRow& tick() const { return before_; }
  [[nodiscard]] const std::vector<estimator::CameraPose>& cameras() const { return cameras_; }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return beat_.warnings(); }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::invalid_argument(beat_.place() + ": " + what +
                                "; was a file of the recording changed?");
  }

  void take_frames(const BeatRow& row, std::int64_t woke_ns, ReplaySummary& summary) {
    std::array<std::uint64_t, can::max_buses> due{};
    std::uint64_t all = 0;
    for (std::size_t bus = 0; bus < due.size(); ++bus) {
      if (row.frames[bus] < before_.frames[bus]) fail("a count of frames falls");
      due[bus] = row.frames[bus] - before_.frames[bus];
      all += due[bus];
    }
    for (; all > 0; --all) {
      const can::Frame* const next = frames_ ? frames_->next() : nullptr;
      if (next == nullptr) fail(fmt::format("{} ends before this tick", recorded_frames));
      can::Frame frame = *next;
      if (due[frame.bus] == 0)
        fail(fmt::format("{} has frames of another bus here", recorded_frames));
      --due[frame.bus];
      if (frame.time_ns != 0) frame.time_ns -= offset_ns_;
      pipeline_.take(frame, woke_ns);
      ++summary.frames;
    }
  }

  void take_cameras(const BeatRow& row, ReplaySummary& summary) {
    if (row.camera_poses < before_.camera_poses || row.camera_messages < before_.camera_messages ||
        row.camera_messages - before_.camera_messages < row.camera_poses - before_.camera_poses)
      fail("a count of camera messages falls");
    if (row.camera_poses > cameras_.size())
      fail(fmt::format("{} ends before this tick", recorded_cameras));
    for (std::uint64_t i = before_.camera_poses; i < row.camera_poses; ++i) {
      pipeline_.take(cameras_[i]);
      ++summary.cameras;
    }
    // Camera messages without a pose were unusable, but are counted, too.
    const std::uint64_t poses = row.camera_poses - before_.camera_poses;
    for (std::uint64_t i = row.camera_messages - before_.camera_messages; i > poses; --i)
      pipeline_.take_malformed_camera_message();
  }

  std::int64_t offset_ns_;
  daemon::Pipeline& pipeline_;
  std::ifstream beat_file_;
  CsvReader beat_;
  std::optional<can::LogReader> frames_;
  std::vector<estimator::CameraPose> cameras_;
  BeatRow before_;
};

/// Passes the folder's info.json to `read`. Errors name the file.
void read_info(const std::filesystem::path& folder,
               const std::function<void(const nlohmann::json& info)>& read) {
  const auto file = folder / recorded_info;
  try {
    const std::string text = read_whole(file);
    if (is_nested_too_deep(text))
      throw std::invalid_argument("is not in the format of odom record: it is nested too deep");
    read(nlohmann::json::parse(text));
  } catch (const nlohmann::json::exception& error) {
    throw std::invalid_argument(
        fmt::format("{}: is not in the format of odom record: {}", file.string(), error.what()));
  } catch (const daemon::ConfigError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    const std::string what = error.what();
    throw std::invalid_argument(what.find(folder.string()) == 0 ? what
                                                                : file.string() + ": " + what);
  }
}

void set_recorded_pose(const nlohmann::json& info, daemon::Config& config) {
  if (const auto& pose = info.at("initial_pose"); !pose.is_null())
    config.initial_pose = estimator::Pose2{pose.at(0), pose.at(1), pose.at(2)};
}

}  // namespace

void begin_as_recorded(const std::filesystem::path& folder, daemon::Config& config) {
  read_info(folder, [&config](const nlohmann::json& info) { set_recorded_pose(info, config); });
}

Recording open_recording(const std::filesystem::path& folder) {
  std::error_code ignored;
  if (!std::filesystem::exists(folder / recorded_info, ignored) &&
      std::filesystem::exists(folder / "drive.log", ignored))
    throw std::invalid_argument(
        fmt::format("{0}: is a drive, not a recording of odom record: replay it with --config "
                    "{0}/car.toml --can "
                    "{0}/drive.log",
                    folder.string()));
  Recording recording;
  recording.folder = folder;
  read_info(folder, [&](const nlohmann::json& info) {
    if (const int format = info.at("format"); format != recording_format)
      throw std::invalid_argument(
          fmt::format("is of format {}, this odom reads {}", format, recording_format));
    recording.config = daemon::load_config(folder / recorded_config);
    recording.config.model = daemon::parse_model(info.at("model").get<std::string>());
    recording.camera_expected = info.at("camera_expected");
    recording.config.camera.configured = recording.camera_expected;
    recording.clock_offset_ns = info.at("clock_offset_ns");
    recording.buses = info.at("buses").get<std::vector<std::string>>();
    if (info.at("period_ns") != recording.config.realtime.period_ns)
      throw std::invalid_argument("has another period than " + std::string(recorded_config));
    set_recorded_pose(info, recording.config);
  });
  recording.databases = daemon::load_databases(recording.config, recording.warnings);
  return recording;
}

RecordingReplay replay(const Recording& recording, const RecordedTickSink& sink) {
  can::BusNames buses;
  for (const auto& name : recording.buses) static_cast<void>(buses.index_of(name));
  const auto expected = daemon::expected_buses(recording.config);
  const auto pipeline = std::make_unique<daemon::Pipeline>(recording.config, recording.databases,
                                                           expected, recording.camera_expected);

  RecordingReplay result;
  const auto state = recording.folder / recorded_state;
  try {
    daemon::restore_checkpoint(read_whole(state), *pipeline);
  } catch (const std::invalid_argument& error) {
    result.inexact = error.what();
    if (!result.inexact.starts_with(state.string()))
      result.inexact = state.string() + ": " + result.inexact;
  }

  RecordedDrive drive(recording, buses, *pipeline, result.warnings);
  ReplaySummary& summary = result.summary;
  summary.first_tick_ns = summary.last_tick_ns = drive.begin().time_ns;
  while (const daemon::TickRecord* record = drive.next(summary)) {
    const BeatRow& live = drive.tick();
    summary.add_tick(*pipeline, *record, live.time_ns);
    if (result.difference.empty() &&
        fmt::format("{:016x}", daemon::fingerprint(*record)) != live.record) {
      result.difference = fmt::format("tick {} (t = ", live.tick);
      append_seconds(result.difference, live.time_ns);
      result.difference += ')';
    }
    sink(*record, live.time_ns);
  }
  summary.finish(*pipeline, drive.cameras());
  append(result.warnings, check_sources(pipeline->decoder(), summary));
  append(result.warnings, check_mode(summary));
  append(result.warnings, diagnostics::kind("file_content"), drive.warnings());
  return result;
}

}  // namespace odomd::tools
