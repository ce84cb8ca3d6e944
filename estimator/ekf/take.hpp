// One sample into the state of its instant: the gate, the update, and what follows from a sensor
// that keeps disagreeing. A pure function of state and sample, so that a window can be replayed.
#pragma once

#include "estimator/ekf/camera.hpp"
#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// Everything that does not change while the filter runs.
struct Context {
  CarModel model;
  CameraGate camera;
  integrity::Sensors sensors;
  double period_s = 0.005;
};

/// Moves the state to `time_ns`, not before its own time. A step is at most one and a half
/// periods long.
void advance(const Context& context, State& state, std::int64_t time_ns) noexcept;

/// The model's inputs as they stand at the state's time: too old ones do not count.
[[nodiscard]] Input input_of(const State& state) noexcept;

/// Whether the gyro is trusted, and was fused so lately that it tells the turn.
[[nodiscard]] bool gyro_alive(const State& state) noexcept;

/// Takes a sample whose time is the state's. Of a source that agrees with the others and is
/// rejected for too long (the gyro 50 ms, the lateral accelerometer 0.2 s, the other one 1.5 s, a
/// wheel 0.1 s) the filter gives in: the variance of what it measures, of an accelerometer of its
/// bias, grows as far as the sample is off, and the sample is fused.
[[nodiscard]] Judgement take(const Context& context, State& state, const Sample& sample) noexcept;

}  // namespace odomd::estimator::full
