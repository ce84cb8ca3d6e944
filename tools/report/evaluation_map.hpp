// The trajectories of a drive over each other: what is drawn and what the legend says.
#pragma once

#include <string>

#include "tools/chart/map.hpp"
#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools {

/// Reference and aligned estimates within their common time, camera poses as dots; cm/m and heading
/// in the legend.
[[nodiscard]] chart::Map evaluation_map(const EvaluatedDrive& drive, const std::string& title);

}  // namespace odomd::tools
