// An estimate of a part of the drive: a pose file that was cut off, or has a hole.
#pragma once

#include <string>

#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// What to say where the estimate covers less than nine tenths of the way that the reference
/// drives; empty where it covers more. Where the car stands nothing is missed.
[[nodiscard]] std::string coverage_doubt(const Trajectory& reference, const Trajectory& estimate);

}  // namespace odomd::tools
