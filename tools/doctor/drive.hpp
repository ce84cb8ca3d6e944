// Replays a drive with its configuration, and checks whether its sensors, camera and reference have
// the right signs, sides, axles, axes, units and times.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/latency/latency_estimate.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::doctor {

struct DriveExamination {
  diagnostics::Diagnostics diagnostics;  ///< causes without their consequences
  std::string note;  ///< checks that were not possible, and guesses of odom init
};

/// How many lines of a configuration odom init has marked as guesses, in words; empty for none.
[[nodiscard]] std::string guesses_in(const std::filesystem::path& config);

/// Finds faults of a drive: in its configuration, in its traffic (examine_traffic() in bus.hpp) and
/// in its replay. Throws std::invalid_argument if the drive cannot be replayed.
[[nodiscard]] DriveExamination examine_drive(const Drive& drive);

// The parts of examine_drive() that check sensors beyond the replay.

/// Finds the sensor with a wrong scale. Compares distances of the wheels, turns from gyro, wheels
/// and steering, and accelerations with the poses of camera or reference, and with each other. The
/// result is the factor on one sensor, the wheels of an axle or all wheels that explains the
/// comparisons best (scales.cpp). Nothing if no factor is certain and distinct.
[[nodiscard]] std::optional<diagnostics::Diagnostic> find_wrong_scale(const Drive& drive,
                                                                      const SignalLog& log);

// Finds sensors whose stated latency is wrong, and camera poses that are not on the bus's clock
// (latencies.cpp).

/// Reports each source whose time offset to the gyro is too large, or only the gyro if its wrong
/// latency explains equal offsets of all others.
[[nodiscard]] diagnostics::Diagnostics examine_latencies(const daemon::Config& config,
                                                         std::span<const SourceOffset> offsets);

/// Sources whose latency this drive cannot determine, in words; empty if there are none.
[[nodiscard]] std::string latencies_unjudged(std::span<const SourceOffset> offsets);

}  // namespace odomd::tools::doctor
