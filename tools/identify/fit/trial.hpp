// The value of fitted numbers for the filter: replays the drive by dead reckoning with and without
// them, and compares it with its own poses.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "tools/identify/common/finding.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::fitting {

/// Takes the values that reduce the errors, one group after the other, the best first, as long as
/// the drives improve or stay as they are. Drops those that do harm together with later ones. Marks
/// the values that are not taken, with the reason: they stay as configured. Also finds how much of
/// the accelerometers to take: if they measure mostly vibration, the filter does better with a
/// part. `progress` is called now and then. Drives are those of trial_drive().
void try_out(Findings& findings, std::span<const tools::Drive> drives,
             const std::function<void(const std::string&)>& progress);

}  // namespace odomd::tools::fitting
