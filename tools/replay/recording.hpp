// Reads a recording: its configuration, and its drive, which it replays through the pipeline tick
// by tick, exactly as it ran live. docs/recording.md has the formats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "can_protocol/dbc/dbc.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/record.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

struct Recording {
  std::filesystem::path folder;
  daemon::Config config;  ///< in force during the drive
  std::vector<can::Database> databases;
  std::vector<std::string> buses;
  bool camera_expected = false;
  std::int64_t clock_offset_ns = 0;  ///< the recording's clock - CLOCK_MONOTONIC
  diagnostics::Diagnostics warnings;
};

/// Throws std::invalid_argument that names the file and the problem.
[[nodiscard]] Recording open_recording(const std::filesystem::path& folder);

/// Sets the initial pose to that of the recording's first tick, if it had one: a recording may
/// begin far from [initial]. Throws like open_recording().
void begin_as_recorded(const std::filesystem::path& folder, daemon::Config& config);

/// Receives a replayed tick and its time on the recording's clock.
using RecordedTickSink =
    std::function<void(const daemon::TickRecord& record, std::int64_t time_ns)>;

struct RecordingReplay {
  ReplaySummary summary;
  std::string inexact;     ///< why the state at the beginning could not be used; empty: it was
  std::string difference;  ///< the first tick that differs from the published one; empty: none
  diagnostics::Diagnostics warnings;
};

/// Replays the recording: its published ticks, each with the inputs that it had. Every tick is
/// passed to `sink`. If the state at the beginning cannot be used, starts at the recorded pose.
/// Warns like check_sources() and check_mode(). Throws std::invalid_argument for files that do not
/// fit each other.
RecordingReplay replay(const Recording& recording, const RecordedTickSink& sink);

}  // namespace odomd::tools
