// What the filter makes of the sources' agreement: what one that is at fault has made of the pose
// is taken off it again, and a filter that has gone astray goes on from what the others say.
#pragma once

#include "estimator/ekf/state.hpp"
#include "estimator/ekf/take.hpp"

namespace odomd::estimator::full {

/// Holds the sources against each other, and the filter against what they agree on: where it has
/// gone astray for a while, it goes on from there, and doubts its pose by as much.
void apply_integrity(const Context& context, State& state) noexcept;

}  // namespace odomd::estimator::full
