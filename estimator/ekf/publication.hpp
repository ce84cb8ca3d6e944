// Between the state and the world: what of it is published, what a successor takes back from there,
// and what is known before either.
#pragma once

#include "estimator/common/estimate.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/take.hpp"

namespace odomd::estimator::full {

/// How far each state may be off before anything was measured.
[[nodiscard]] Vector prior_sigma(const FilterSettings& settings) noexcept;

/// Everything of an estimate that the state alone says. The odometry frame, resets and the mode are
/// the filter's. Calibrations are valid where they are known clearly better than by `prior_sigma`.
[[nodiscard]] Estimate publication(const Context& context, const State& state,
                                   const Vector& prior_sigma) noexcept;

/// The state that goes on from a usable predecessor (predecessor.hpp) that is `gap_s` [s] old:
/// pose, velocity and covariances moved on by the gap, its calibrations, its last camera pose.
[[nodiscard]] State resumed(const Estimate& predecessor, double gap_s,
                            const Vector& prior_sigma) noexcept;

}  // namespace odomd::estimator::full
