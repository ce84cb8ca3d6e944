// The measured direction of travel: the sign of unsigned wheel speeds.
//
// docs/model.md, "Gates and rejection timeouts".
#pragma once

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Takes a sample of the direction: the sign of unsigned wheel speeds, which may have been wrong
/// until now. 0 (unknown) keeps the last direction until the car may have stood. `gated`: a single
/// reversal that is too fast for a car.
[[nodiscard]] Verdict take_direction(const CarModel& model, State& state,
                                     const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
