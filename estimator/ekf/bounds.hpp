// Bounds of the covariance, and the check of a state before it is published.
//
// docs/model.md, "Bounds".
#pragma once

#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Inflates P against rounding, and limits its variances by D P D. Once a tick.
void limit(State& state) noexcept;

/// Whether the state is finite and possible, and P positive definite.
[[nodiscard]] bool is_valid(const State& state) noexcept;

}  // namespace odomd::estimator::full
