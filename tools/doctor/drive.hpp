// Replays a drive with its configuration, and checks signs, sides, axles, axes, units and times of
// its sensors, its camera and its reference.
#pragma once

#include <filesystem>
#include <string>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::doctor {

struct DriveExamination {
  diagnostics::Diagnostics diagnostics;  ///< causes without their consequences
  std::string note;                      ///< checks that were not possible; may be empty
};

/// How many lines of a configuration odom init has marked as guesses, in words; empty for none.
[[nodiscard]] std::string guesses_in(const std::filesystem::path& config);

/// Faults of a drive in its configuration, its traffic (examine_traffic() in bus.hpp), and in the
/// replay. Throws std::invalid_argument if the drive cannot be replayed.
[[nodiscard]] DriveExamination examine_drive(const Drive& drive);

}  // namespace odomd::tools::doctor
