// The charts of an evaluated drive.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/chart/picture.hpp"
#include "tools/evaluation/evaluated_drive.hpp"
#include "tools/report/charts.hpp"

namespace odomd::tools::report {

/// Index of the estimate that is shown in detail: the last whose samples were tested, otherwise the
/// last with a covariance, otherwise the last.
[[nodiscard]] std::size_t focus_of(const EvaluatedDrive& drive);

[[nodiscard]] Figure trajectories(const EvaluatedDrive& drive);

/// Figures for a drive with a reference; otherwise none. Error over horizon (not with a camera as
/// reference); position and heading error of all estimates over time; along, cross and heading
/// error of the focus with three sigmas, and its NEES.
[[nodiscard]] std::vector<Figure> errors(const EvaluatedDrive& drive);

/// Errors over the mean speed of each drive, one curve per model: 35 ms, end per metre, heading at
/// the end. Figures that no drive has are left out.
[[nodiscard]] std::vector<Figure> errors_by_speed(const std::vector<EvaluatedDrive>& drives);

/// For the focus, one figure per source whose samples were tested; three for the camera.
[[nodiscard]] std::vector<Figure> innovations(const EvaluatedDrive& drive);

}  // namespace odomd::tools::report
