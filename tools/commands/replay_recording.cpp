#include "tools/commands/replay_recording.hpp"

#include <chrono>
#include <filesystem>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/json_text.hpp"
#include "tools/cli/output.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/pose_csv.hpp"
#include "tools/drive_files/pose_file.hpp"
#include "tools/drive_files/recording_folder.hpp"
#include "tools/replay/recording.hpp"
#include "tools/replay/recording_verifier.hpp"
#include "tools/replay/replay_json.hpp"

namespace odomd::tools {
namespace {

std::vector<std::filesystem::path> files_of(const Recording& recording) {
  std::vector<std::filesystem::path> all = recording.config.can.dbc;
  for (const char* name : {recorded_frames, recorded_cameras, recorded_beat, recorded_poses,
                           recorded_info, recorded_state, recorded_config})
    all.push_back(recording.folder / name);
  return all;
}

void report(const RecordingOptions& options, const RecordingReplay& replayed, double seconds,
            const std::optional<RecordingVerifier>& verifier,
            const diagnostics::Diagnostics& warnings) {
  const ReplaySummary& summary = replayed.summary;
  const double drive = static_cast<double>(summary.last_tick_ns - summary.first_tick_ns) * 1e-9;
  if (options.json) {
    nlohmann::ordered_json json = replay_json(summary, seconds, warnings);
    json["from_state"] = replayed.inexact.empty();
    if (verifier) json["bit_identical"] = replayed.inexact.empty() && !verifier->difference();
    std::cerr << json_text(json) << '\n';
    return;
  }
  warn("replay", warnings);
  std::cerr << fmt::format(
      "replayed {:.1f} s in {:.3f} s ({:.0f} times real time): {} frames, {} camera poses, {} "
      "ticks, at the end {}\n",
      drive, seconds, drive / seconds, summary.frames, summary.cameras, summary.ticks,
      mode_name(summary.last_mode));
  if (verifier && replayed.inexact.empty() && !verifier->difference())
    std::cerr << fmt::format("bit-identical to what was published: {} ticks, {} rows of poses\n",
                             verifier->ticks(), verifier->rows());
}

}  // namespace

void replay_recording(const RecordingOptions& options) {
  const Recording recording = open_recording(options.folder);
  std::optional<RecordingVerifier> verifier;
  if (options.verify) verifier.emplace(recording.folder);
  check_outputs(std::vector<Output>{{"--out", options.out == "-" ? "" : options.out}},
                files_of(recording));
  std::optional<WholeFile> file;
  if (!options.out.empty() && options.out != "-") file.emplace(options.out);
  std::optional<PoseFile> poses;
  if (!options.out.empty()) poses.emplace(file ? file->stream() : std::cout);

  const auto start = std::chrono::steady_clock::now();
  const RecordingReplay replayed =
      replay(recording, [&](const daemon::TickRecord& record, const RecordedTick& live) {
        if (verifier) verifier->take(record, live);
        if (poses && record.initialised) poses->add(record, live.time_ns);
      });
  const bool lacks_poses = poses && replayed.summary.poses == 0;
  if (poses) poses->finish();
  if (file && !lacks_poses) file->finish();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  diagnostics::Diagnostics warnings = recording.warnings;
  append(warnings, replayed.warnings);
  if (!replayed.inexact.empty())
    warnings.push_back(found(diagnostics::kind("replay_without_state"), {},
                             "the replay begins with the recorded pose, not with the filter's "
                             "state: " +
                                 replayed.inexact));
  report(options, replayed, seconds.count(), verifier, warnings);
  if (verifier && !replayed.inexact.empty())
    throw std::runtime_error("cannot be verified without the filter's state: " + replayed.inexact);
  if (verifier && verifier->difference())
    throw std::runtime_error("differs from the published poses: " + *verifier->difference());
  if (lacks_poses) throw std::runtime_error("the recording holds no pose: no pose file is written");
}

}  // namespace odomd::tools
