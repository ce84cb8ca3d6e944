// Gates a scalar sample, fuses it, and handles the rejection timeout of its source.
//
// docs/model.md, "Gates and rejection timeouts".
#pragma once

#include <cstdint>

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

/// A longer gap between two samples does not widen a gate any further [s].
inline constexpr double longest_gap_s = 0.2;

/// Time of the last fused sample of this source (of any wheel, for a wheel); 0: never.
[[nodiscard]] std::int64_t last_fused_ns(const State& state, Source source) noexcept;

/// Whether the gyro is trusted and has a recent fused sample.
[[nodiscard]] bool gyro_alive(const State& state) noexcept;

/// Time since the first of the consecutive rejected samples that end with this one [s].
[[nodiscard]] double rejected_s(State& state, const Sample& sample) noexcept;

/// The states that a sample of the car's own sensors may correct.
struct Updates {
  bool heading = false;  ///< ψ, ψ̇ and ε: for a gyro's samples; without a gyro, for all samples
  SlowVector slow = none();
};

/// Fuses the sample if ν²/S is below the gate, with S widened by a possible change of motion. After
/// the rejection timeout of its source, if integrity agrees, the variance of yaw rate, v_x or an
/// accelerometer's bias grows by ν², and the sample is fused too (`forced`).
[[nodiscard]] Judgement judge(const CarModel& model, State& state, const Sample& sample,
                              const Prediction& prediction, const Updates& updates) noexcept;

}  // namespace odomd::estimator::full
