// A lap that ends where it began needs no reference: the estimate should end at its start.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools {

/// End error and end heading (to the nearest whole turn) of an estimate of a closed lap, with its
/// own path length. Figures that need a reference stay empty. Throws std::invalid_argument for
/// fewer than two rows.
[[nodiscard]] Evaluation evaluate_closed_loop(const Trajectory& estimate);

/// Whether to assume a closed lap without --closed-loop: the estimate ends within 3 % of the path
/// and 20° of its start, which its own drift may explain.
[[nodiscard]] bool closes(const Evaluation& loop);

/// The evaluation of a drive whose errors are not known.
[[nodiscard]] Evaluation without_errors(const Evaluation& open);

/// Checks with the best estimate that the car came back. Throws std::invalid_argument if it moved
/// less than 1 m, or ends more than a tenth of the path, half the largest distance, or 45° from the
/// start. More than 3 % of the path or 20° gives a diagnostic: estimate or car may be off.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_that_it_closes(
    const std::string& drive, std::span<const Evaluation> evaluations);

}  // namespace odomd::tools
