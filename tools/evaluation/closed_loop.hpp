// A lap that ends where it began judges itself: no reference is needed to say how far the estimate
// ends from its start.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/evaluation.hpp"

namespace odomd::tools {

/// End error and end heading (to the next whole turn) of an estimate whose car came back to where
/// it started; the path length is the estimate's own. What needs a reference stays empty. Throws
/// std::invalid_argument for less than two rows.
[[nodiscard]] Evaluation evaluate_closed_loop(const Trajectory& estimate);

/// Whether the car can be taken to have come back, by the best of the estimates. Throws
/// std::invalid_argument where it hardly moved, or where even that ends more than a tenth of the
/// path, half the lap's size, or 45° from the start; returns a warning (without the drive's name)
/// where more than 3 % of the path or 20°: then nobody knows whether estimate or car is off. Empty:
/// nothing to be said.
[[nodiscard]] std::string check_that_it_closes(const std::string& drive,
                                               std::span<const Evaluation> evaluations);

}  // namespace odomd::tools
