// Checks whether the headings of a trajectory fit its path. A file in degrees, or with a clockwise
// yaw, can be read, but all results from it are wrong.
#pragma once

#include <string>

#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// A warning about headings that do not follow the path; empty if they do, or if the car hardly
/// moves or turns. A car that reverses or drifts gives no warning.
[[nodiscard]] std::string heading_warning(const Trajectory& trajectory);

}  // namespace odomd::tools
