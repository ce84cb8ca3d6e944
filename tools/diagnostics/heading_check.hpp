// Checks whether the headings of a trajectory fit its path. A file in degrees, or with a clockwise
// yaw, can be read, but all results from it are wrong.
#pragma once

#include <optional>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// Nothing if the headings follow the path, or if the car hardly moves or turns. A car that
/// reverses or drifts gives no warning.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_headings(const Trajectory& trajectory);

}  // namespace odomd::tools
