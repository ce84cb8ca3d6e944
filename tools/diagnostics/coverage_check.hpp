// Detects an estimate of only a part of the drive: a pose file that was cut off or has a gap.
#pragma once

#include <string>

#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// A warning if the estimate covers less than nine tenths of the reference's path; else empty. Time
/// at standstill does not count.
[[nodiscard]] std::string coverage_warning(const Trajectory& reference, const Trajectory& estimate);

}  // namespace odomd::tools
