// Whether the headings of a trajectory can be those of a car that drove it: a file in degrees, or
// with a yaw that is counted clockwise, is read like any other, and every number made of it is
// wrong.
#pragma once

#include <string>

#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// What to say of headings that do not go with the way that is driven; empty where they do, where
/// the car hardly moves, and where it hardly turns. A car that reverses or drifts is not doubted.
[[nodiscard]] std::string heading_doubt(const Trajectory& trajectory);

}  // namespace odomd::tools
