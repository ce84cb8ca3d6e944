// odom replay: a recorded drive through the daemon's pipeline, in virtual time.
#include <span>

#include <fmt/ranges.h>

#include "daemon/core/config.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/core/usage.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/drive_files/recording_folder.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/log_options.hpp"
#include "tools/replay/recording.hpp"
#include "tools/replay/replay_checks.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {
namespace {

struct ReplayOptions {
  std::string drive;
  std::string config;
  std::vector<std::string> logs;
  std::vector<std::string> databases;
  std::string camera;
  std::string model;
  std::string initial;
  std::string out;
  std::string innovations;
  std::string recording;
  bool verify = false;
  bool json = false;
  can::Damage damage = can::Damage::left_out;
};

daemon::Config configuration(const ReplayOptions& options) {
  daemon::Config config =
      options.drive.empty()
          ? daemon::load_config(options.config)
          : drive_config({.folder = options.drive, .config = options.config, .reference = {}});
  if (!options.logs.empty()) config.can.sources = options.logs;
  if (!options.databases.empty())
    config.can.dbc.assign(options.databases.begin(), options.databases.end());
  if (!options.model.empty()) config.model = daemon::parse_model(options.model);
  if (!options.initial.empty()) config.initial_pose = daemon::parse_pose(options.initial);
  return config;
}

std::vector<std::filesystem::path> inputs_of(const ReplayOptions& options,
                                             const daemon::Config& config) {
  std::vector<std::filesystem::path> inputs = config.can.dbc;
  inputs.insert(inputs.end(), {config.file, options.camera});
  for (const std::string& source : config.can.sources)
    inputs.emplace_back(source == "-" ? "/dev/stdin" : source);
  return inputs;
}

// `outputs`: number and kind of the results; `more`: further members of the JSON.
void report(const ReplayOptions& options, const ReplaySummary& summary, double seconds,
            const diagnostics::Diagnostics& warnings, const std::string& outputs,
            const nlohmann::ordered_json& more = nlohmann::ordered_json::object()) {
  if (options.json) {
    nlohmann::ordered_json json = replay_json(summary, seconds, warnings);
    json.update(more);
    std::cerr << json_text(json) << '\n';
    return;
  }
  const double drive = static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9;
  warn("replay", warnings);
  std::cerr << fmt::format(
      "replayed {:.1f} s in {:.3f} s ({:.0f} times real time): {} frames, {} camera poses, {}, at "
      "the end {}\n",
      drive, seconds, drive / seconds, summary.frames, summary.cameras, outputs,
      mode_name(summary.last_mode));
}

ReplaySummary play(daemon::Pipeline& pipeline, std::int64_t period_ns, can::MergedLog& log,
                   const CameraLog& camera, const PoseSink& sink, const JudgementSink& judged) try {
  return replay(
      pipeline, period_ns, [&log] { return log.next(); }, camera.poses, sink, judged);
} catch (const PauseError& error) {
  throw PauseError(log.position() + error.what());
}

void run(ReplayOptions options) {
  daemon::Config config = configuration(options);
  if (const auto own = std::filesystem::path(options.drive) / "camera.csv";
      !options.drive.empty() && options.camera.empty() && std::filesystem::exists(own))
    options.camera = own.string();
  diagnostics::Diagnostics warnings;
  const std::vector<can::Database> databases = daemon::load_databases(config, warnings);

  can::BusNames buses;
  std::uint64_t unmapped = 0;
  can::MergedLog log = open_mapped_log(config, databases, config.can.sources, buses, options.damage,
                                       [&unmapped](const can::Frame&) { ++unmapped; });

  check_outputs(std::vector<Output>{{"--out", options.out}, {"--innovations", options.innovations}},
                inputs_of(options, config));
  CameraLog camera;
  if (!options.camera.empty()) {
    camera = read_camera_log(options.camera);
    if (camera.poses.empty()) warnings.push_back(no_camera_pose(options.camera));
  } else if (config.camera.configured)
    warnings.push_back(found(diagnostics::kind("no_camera_file"), config.file.string(),
                             "has a [camera], but its poses are not given: this is odometry only"));

  const auto pipeline =
      std::make_unique<daemon::Pipeline>(config, databases, buses.all(), !camera.poses.empty());
  WholeFile file(options.out);
  std::optional<WholeFile> innovations;
  JudgementSink judged;
  if (!options.innovations.empty()) {
    innovations.emplace(options.innovations).stream() << innovation_header();
    judged = [&innovations](std::span<const estimator::Judgement> judgements) {
      std::string text;
      for (const estimator::Judgement& one : judgements) append_innovation_rows(text, one);
      innovations->stream() << text;
    };
  }

  const auto start = std::chrono::steady_clock::now();
  file.stream() << record_header();
  const auto write = [&file](const daemon::TickRecord& record) {
    std::string row;
    append_record_row(row, record, record.pose.time_ns);
    file.stream() << row;
  };
  ReplaySummary summary = play(*pipeline, config.realtime.period_ns, log, camera, write, judged);
  summary.unmapped = unmapped;
  if (innovations) innovations->finish();
  if (summary.poses > 0) file.finish();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  append(warnings, camera.warnings);
  append(warnings, diagnostics::kind("log_content"), log.warnings());
  append(warnings, check_replay(pipeline->decoder(), summary));
  if (summary.camera_units.empty())
    append(warnings, check_initial_pose(config, camera.poses, summary.first_tick_ns));
  report(options, summary, seconds.count(), warnings, fmt::format("{} poses", summary.poses));
  if (summary.poses == 0) throw std::runtime_error("there is no pose: no pose file is written");
}

// All files of a recording, which --out must not overwrite.
std::vector<std::filesystem::path> files_of(const Recording& recording) {
  std::vector<std::filesystem::path> all = recording.config.can.dbc;
  for (const char* name : {recorded_frames, recorded_cameras, recorded_beat, recorded_poses,
                           recorded_info, recorded_state, recorded_config})
    all.push_back(recording.folder / name);
  return all;
}

void replay_recording(const ReplayOptions& options) {
  const Recording recording = open_recording(options.recording);
  check_outputs(std::vector<Output>{{"--out", options.out}}, files_of(recording));
  std::optional<WholeFile> file;
  if (!options.out.empty()) file.emplace(options.out).stream() << record_header();

  const auto start = std::chrono::steady_clock::now();
  const RecordingReplay replayed =
      replay(recording, [&file](const daemon::TickRecord& record, std::int64_t time_ns) {
        if (!file || !record.initialised) return;
        std::string row;
        append_record_row(row, record, time_ns);
        file->stream() << row;
      });
  const bool lacks_poses = file && replayed.summary.poses == 0;
  if (file && !lacks_poses) file->finish();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  diagnostics::Diagnostics warnings = recording.warnings;
  append(warnings, replayed.warnings);
  if (!replayed.inexact.empty())
    warnings.push_back(found(diagnostics::kind("replay_without_state"), {},
                             "the replay begins with the recorded pose, not with the filter's "
                             "state: " +
                                 replayed.inexact));
  const bool identical = options.verify && replayed.inexact.empty() && replayed.difference.empty();
  nlohmann::ordered_json more{{"from_state", replayed.inexact.empty()}};
  if (options.verify) more["bit_identical"] = identical;
  report(options, replayed.summary, seconds.count(), warnings,
         fmt::format("{} ticks", replayed.summary.ticks), more);
  if (identical && !options.json)
    std::cerr << fmt::format("bit-identical to what was published: {} ticks\n",
                             replayed.summary.ticks);
  if (options.verify && !replayed.inexact.empty())
    throw std::runtime_error("cannot be verified without the filter's state: " + replayed.inexact);
  if (options.verify && !replayed.difference.empty())
    throw std::runtime_error("differs from the published poses: " + replayed.difference);
  if (lacks_poses) throw std::runtime_error("the recording holds no pose: no pose file is written");
}

}  // namespace

void add_replay(Command odom) {
  auto options = std::make_shared<ReplayOptions>();
  Command replay = odom.add_subcommand(
      "replay", "Replay a drive through the daemon's pipeline, as fast as the machine allows");
  replay.add("--drive,DIR", "DIR", options->drive,
             "Folder of a drive: its car.toml, its drive.log or can.log, and "
             "its camera.csv if there is one");
  replay.add("--config", "FILE", options->config,
             "Configuration of the car (TOML); with --drive, it replaces the drive's car.toml");
  replay.add("--can", "LOG", options->logs,
             "Log of candump -L, or - for standard input; repeatable, for several buses; instead "
             "of [can] source or the drive's");
  replay.add("--dbc", "DBC", options->databases,
             "Database (DBC); repeatable; instead of [can] dbc");
  replay.add("--camera", "CSV", options->camera, "Camera log; instead of the drive's");
  replay.add("--model", fmt::format("{}", fmt::join(estimator::model_names, "|")), options->model,
             "Model of the filter; instead of [filter] model");
  replay.add("--initial", "X,Y,YAW", options->initial,
             "Pose to start from [m, m, rad]; instead of [initial] pose");
  replay.add("--innovations", "CSV", options->innovations,
             "Write the innovation of every sample; only with the model full");
  replay.add("--recording", "DIR", options->recording,
             "Folder of odom record, instead of all options above",
             {excludes("--drive"), excludes("--config"), excludes("--can"), excludes("--dbc"),
              excludes("--camera"), excludes("--model"), excludes("--initial"),
              excludes("--innovations")});
  replay.add("--out", "CSV", options->out, "Pose file to write, or - for standard output");
  replay.add_flag("--verify", options->verify,
                  "Compare every tick of the recording bit by bit with what was published",
                  {needs("--recording")});
  replay.add_flag("--json", options->json, "Print summary and warnings as JSON on standard error");
  add_strict(replay, options->damage);
  replay.footer(
      "Examples:\n"
      "  odom replay --drive lap --out pose.csv\n"
      "  odom replay --config car.toml --can drive.log --out pose.csv\n"
      "  odom replay --config car.toml --can drive.log --camera camera.csv --model paper \\\n"
      "      --initial 1.2,0.4,1.57 --out pose.csv\n"
      "  odom replay --recording drive-20261121-140300 --verify\n\n"
      "The pose starts at --initial; otherwise at that of the configuration, at the first\n"
      "camera pose, or at 0. The output has one row per tick after initialisation, with times\n"
      "on the log's clock.\n\n" +
      std::string(daemon::models_help));
  replay.callback([options] {
    if (options->out.empty() && !options->verify) require("--out");
    if (!options->recording.empty()) {
      replay_recording(*options);
      return;
    }
    if (options->config.empty() && options->drive.empty())
      require("--drive, --config or --recording");
    run(*options);
  });
}

}  // namespace odomd::tools
