// Detects an estimate compared with the reference of another drive. Both clocks start alike, so
// every figure would look like that of a bad filter.
#pragma once

#include <string>

#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// A warning if the two turn so differently from second to second that they cannot be of one drive,
/// or if they look exchanged (sigmas in the reference alone). Empty otherwise, and if the reference
/// hardly turns.
[[nodiscard]] std::string drive_mismatch(const Trajectory& reference, const Trajectory& estimate);

}  // namespace odomd::tools
