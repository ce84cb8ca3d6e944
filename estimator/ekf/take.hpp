// Applies one sample to the state at its time: plausibility, gate, update, standstill. A pure
// function of state and sample, so that a window can be replayed.
//
// docs/model.md, "Process".
#pragma once

#include "estimator/ekf/camera.hpp"
#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// The constants of a filter.
struct Context {
  CarModel model;
  CameraGate camera;
  double period_s = FilterSettings{}.period_s;
};

/// Propagates the state to `time_ns`, in steps of at most one and a half periods.
void advance(const Context& context, State& state, std::int64_t time_ns) noexcept;

/// The model's inputs at the state's time, unless they are too old.
[[nodiscard]] Input input_of(const State& state) noexcept;

/// Applies a sample whose time is the state's.
[[nodiscard]] Judgement take(const Context& context, State& state, const Sample& sample) noexcept;

/// Checks the sources, takes back the effect of a faulty source on the pose, and resets the motion
/// to the consensus if the filter has deviated from it for a while.
void apply_integrity(const Context& context, State& state) noexcept;

}  // namespace odomd::estimator::full
