// A lap that ends where it began needs no reference: the estimate should end at its start.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools {

/// End error and end heading (to the nearest whole turn) of an estimate of a closed lap; the path
/// length is the estimate's own. Figures that need a reference stay empty. Throws
/// std::invalid_argument for fewer than two rows.
[[nodiscard]] Evaluation evaluate_closed_loop(const Trajectory& estimate);

/// Whether the drive is a closed lap, for one that nobody said is: by this evaluation of it as one
/// it ends within 3 % of the path and 20°, where the error is the estimate's.
[[nodiscard]] bool closes(const Evaluation& loop);

/// The same for a drive whose errors are not known.
[[nodiscard]] Evaluation without_errors(const Evaluation& open);

/// Checks by the best of the estimates that the car came back. Throws std::invalid_argument if it
/// hardly moved, or if even the best ends more than a tenth of the path, half the lap's size, or
/// 45° from the start. More than 3 % of the path or 20° is a diagnostic: then it is not known
/// whether the estimate or the car is off.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_that_it_closes(
    const std::string& drive, std::span<const Evaluation> evaluations);

}  // namespace odomd::tools
