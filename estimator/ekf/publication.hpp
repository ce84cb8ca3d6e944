// Between the state and the world: what of it is published, what a successor takes back from there,
// and what is known before either.
//
// docs/model.md, "Publication".
#pragma once

#include "estimator/common/estimate.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/ekf/process.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// The state before anything was measured.
[[nodiscard]] State initial_state(const FilterSettings& settings) noexcept;

/// Everything of an estimate that the state alone says. The odometry frame, resets and the mode are
/// the filter's. Calibrations are valid where they are known clearly better than in `fresh`.
[[nodiscard]] Estimate publication(const CarModel& model, const Input& input, double period_s,
                                   const State& state, const State& initial) noexcept;

/// The state that goes on from a usable predecessor (predecessor.hpp) that is `gap_s` [s] old:
/// pose, velocity and covariances moved on by the gap, its calibrations, its last camera pose.
[[nodiscard]] State resumed(const Estimate& predecessor, double gap_s,
                            const State& initial) noexcept;

/// A state that nothing was heard of for `gap_s` [s]: whether the car has gone on as it went or
/// not.
void bridge_gap(State& state, double gap_s) noexcept;

}  // namespace odomd::estimator::full
