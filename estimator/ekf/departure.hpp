// When the motion begins to be followed, when a car that stands sets off, and which way it goes.
#pragma once

#include "estimator/common/measurement.hpp"
#include "estimator/ekf/plausibility.hpp"
#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// The motion is followed from here on, at the speed of a wheel's sample; and made up for since the
/// wheel that vouches for it was heard, half of it uncertain. From a camera's pose until then the
/// car may have gone as fast, or stood.
void begin_motion(State& state, const Sample& sample) noexcept;

/// Whether a car that stands sets off with a wheel that turns: most wheels do, two of them or one
/// that has said so before, where the next is not long in coming; or half of them for so long that
/// the others must be dead. Driven wheels that spin while the others rest move no car.
[[nodiscard]] bool sets_off(State& state, const Sample& sample, const WheelCount& wheels) noexcept;

/// What tells which way the car goes, for wheels that do not: until now they may have had the wrong
/// sign. Where it says that it does not know, the last that did counts until the car may have
/// stood. `gated`: one telegram that turns a car round which is too fast for it.
[[nodiscard]] Verdict take_direction(const CarModel& model, State& state,
                                     const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
