// An estimate that is held against the reference of another drive: both start their clocks alike,
// and every number made of the two looks like that of a bad filter.
#pragma once

#include <string>

#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// What to say where, from second to second, the two turn so differently that they cannot be of one
/// drive, or where they look exchanged (sigmas in the reference alone); empty where neither is so,
/// and where the reference hardly turns.
[[nodiscard]] std::string drive_mismatch(const Trajectory& reference, const Trajectory& estimate);

}  // namespace odomd::tools
