// What fitted values are worth to the filter: the drive replayed by dead reckoning, with and
// without them, and held against its own poses.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tools/drive.hpp"
#include "tools/identify/finding.hpp"

namespace odomd::tools::fitting {

/// A drive to be replayed, between two times after its first frame [s]; its reference are its
/// poses, smoothed. Throws std::invalid_argument where there are too few of them.
[[nodiscard]] tools::Drive trial_drive(const std::string& name, const daemon::Config& config,
                                       std::span<const std::string> logs,
                                       std::vector<estimator::CameraPose> poses, double from,
                                       double to);

/// Takes the values that lessen the errors, one group after the other, the best first, as long as
/// the drives get better by them or stay as they are; marks the others to be left as configured,
/// with the reason. Beside them finds how much of the accelerometers to take: where they feel
/// little else than vibration the filter does better with a part. `progress` is told now and then.
/// Errors are the means over 35 ms and 1 s, and the rms of position and heading, of parts of each
/// drive and of the whole.
void try_out(Findings& findings, std::span<const tools::Drive> drives,
             const std::function<void(const std::string&)>& progress);

}  // namespace odomd::tools::fitting
