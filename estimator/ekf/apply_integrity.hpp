// Applies the integrity verdict to the filter.
//
// docs/model.md, "Integrity".
#pragma once

#include "estimator/ekf/state.hpp"
#include "estimator/ekf/take.hpp"

namespace odomd::estimator::full {

/// Checks the sources, takes back what a faulty one has done to the pose, and resets the motion to
/// the consensus if the filter has deviated from it for a while.
void apply_integrity(const Context& context, State& state) noexcept;

}  // namespace odomd::estimator::full
