// Plausibility checks of one drive with one configuration: what odom replay and odom evaluate would
// report, to find what is wrong with a car.
#pragma once

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/evaluation/drive_evaluation.hpp"

namespace odomd::tools {

/// Those of the replay, and an initial pose of another drive; with a reference, its units and
/// headings, a reference of another drive, and wrong times of the two. Throws as replay_drive().
[[nodiscard]] diagnostics::Diagnostics check_drive(const Drive& drive);

}  // namespace odomd::tools
