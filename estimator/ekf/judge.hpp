// Gates a scalar sample, fuses it, and handles the rejection timeout of its source. Also estimates
// noise from the data: that of the inertial sensors from the differences of their samples, and the
// scales of process and measurement noise from the innovations.
//
// docs/model.md, "Gates and rejection timeouts".
#pragma once

#include <cstdint>

#include "estimator/ekf/process_model.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

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

/// Replaces the sigma of an inertial sensor's sample by its measured noise,
/// E (z_k - 2 z_k-1 + z_k-2)² / 6, which motion hardly affects. Still and moving samples have
/// separate means, limited to 0.1 to 1 times the stated sigma when still, 0.3 to 3 when moving.
void measure_noise(const Tuning& tuning, State& state, Sample& sample) noexcept;

/// The present noise estimate of a source with the stated sigma `stated`.
[[nodiscard]] SourceNoise noise_of(const Tuning& tuning, const State& state, Source source,
                                   double stated) noexcept;

/// λ ← λ exp(τ/T p (ν² / (H P Hᵀ + R) - 1)), τ the time since the source's last sample, p the share
/// of λ in the variance (gyro: 1). A wheel adapts the scales of a_x and of its own relative error;
/// a gyro adapts that of ε. Call it once for each sample, fused or not.
void adapt_noise_scales(const Tuning& tuning, State& state, const Sample& sample,
                        const Prediction& z, const Innovation& nu) noexcept;

/// Likewise adapts the scale of the position noise, from a camera pose `interval_s` after the
/// previous pose.
void adapt_way_noise_scale(const Tuning& tuning, State& state, double squared_ratio,
                           double interval_s) noexcept;

}  // namespace odomd::estimator::full
