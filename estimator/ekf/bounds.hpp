// What no state is beyond: limits of the covariance, and the check that stands before everything
// that is published.
//
// docs/model.md, "Bounds".
#pragma once

#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Once a tick: P against rounding, and brought down to what nothing is known beyond, by D P D.
void limit(State& state) noexcept;

/// Finite, of a size that a car can have, P positive definite.
[[nodiscard]] bool is_valid(const State& state) noexcept;

}  // namespace odomd::estimator::full
