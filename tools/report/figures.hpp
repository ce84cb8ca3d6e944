// The charts of an evaluated drive.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/chart/drawing.hpp"
#include "tools/evaluation/evaluated_drive.hpp"
#include "tools/report/charts.hpp"

namespace odomd::tools::report {

/// The estimate that the closer look is taken at: the last whose samples were tested, else the last
/// with a covariance, else the last.
[[nodiscard]] std::size_t focus_of(const EvaluatedDrive& drive);

[[nodiscard]] Figure trajectories(const EvaluatedDrive& drive);

/// Against a reference; of a closed loop none: error against horizon, position and heading error of
/// all estimates over time; along, cross and heading error of the focus with three sigmas, and its
/// NEES.
[[nodiscard]] std::vector<Figure> errors(const EvaluatedDrive& drive);

/// Errors over the mean speed of each drive, by model: 35 ms, end per metre, heading at the end.
/// Figures that no drive has are left out.
[[nodiscard]] std::vector<Figure> errors_by_speed(const std::vector<EvaluatedDrive>& drives);

/// Of the focus, a figure a source (of the camera three) whose samples were tested.
[[nodiscard]] std::vector<Figure> innovations(const EvaluatedDrive& drive);

}  // namespace odomd::tools::report
