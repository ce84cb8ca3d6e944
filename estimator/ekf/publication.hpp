// Conversion between the state and published estimates, the initial state, and the checks before a
// state is published.
//
// docs/model.md, "Publication".
#pragma once

#include "estimator/common/estimate.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/ekf/process_model.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// The state before the first sample.
[[nodiscard]] State initial_state(const FilterSettings& settings) noexcept;

/// The part of an estimate that the state alone determines; odometry frame, resets and mode come
/// from the filter. A calibration is valid if it is clearly more precise than in `initial`.
[[nodiscard]] Estimate publication(const CarModel& model, const Input& input, double period_s,
                                   const State& state, const State& initial) noexcept;

/// The state resumed from a usable predecessor (predecessor.hpp) that is `gap_s` [s] old. Pose,
/// velocity and covariances are propagated; calibrations and time of the last camera pose are kept.
[[nodiscard]] State resumed(const CarModel& model, const Estimate& predecessor, double gap_s,
                            const State& initial) noexcept;

/// Widens the covariance of a state without samples for `gap_s` [s], in which the car may or may
/// not have kept its motion.
void bridge_gap(State& state, double gap_s) noexcept;

/// Inflates P against rounding, and limits its variances with D P D. Call it once a tick.
void limit(State& state) noexcept;

/// Whether the state is finite and possible, and P positive definite.
[[nodiscard]] bool is_valid(const State& state) noexcept;

}  // namespace odomd::estimator::full
