// What fitted values are worth to the filter: the drive replayed by dead reckoning, with and
// without them, and held against its own poses.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "tools/identify/common/finding.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::fitting {

/// Takes the values that lessen the errors, one group after the other, the best first, as long as
/// the drives get better by them or stay as they are, and leaves those again that do harm beside
/// later ones; marks what is not taken to be left as configured, with the reason. Beside them finds
/// how much of the accelerometers to take: where they feel little else than vibration the filter
/// does better with a part. `progress` is told now and then. Drives are those of trial_drive().
void try_out(Findings& findings, std::span<const tools::Drive> drives,
             const std::function<void(const std::string&)>& progress);

}  // namespace odomd::tools::fitting
