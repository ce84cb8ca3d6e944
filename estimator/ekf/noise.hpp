// Noise from the data: the inertial sensors' from the differences of their samples, and scales of
// process and measurement noise from the innovations.
//
// docs/model.md, "Noise from the data".
#pragma once

#include "estimator/common/tuning.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

/// Replaces the sigma of an inertial sensor's sample by its measured noise,
/// E (z_k - 2 z_k-1 + z_k-2)² / 6, which motion hardly affects. Still and moving samples have
/// separate means: from 0.1 to 1 of the stated sigma when still; from 0.3 to 3 on the move.
void measure_noise(const Tuning& tuning, State& state, Sample& sample) noexcept;

/// The present noise estimate of a source with the stated sigma `stated`.
[[nodiscard]] SourceNoise noise_of(const Tuning& tuning, const State& state, Source source,
                                   double stated) noexcept;

/// λ ← λ exp(τ/T p (ν² / (H P Hᵀ + R) - 1)), τ the time since the source's last sample, p the share
/// of λ in the variance (gyro: 1). A wheel adapts the scales of a_x and of the wheel's relative
/// error, a gyro the scale of ε. Call it once for each sample, fused or not.
void adapt_noise_scales(const Tuning& tuning, State& state, const Sample& sample,
                        const Prediction& z, const Innovation& nu) noexcept;

/// Likewise adapts the scale of the position noise, from a camera pose `interval_s` after the
/// previous pose.
void adapt_way_noise_scale(const Tuning& tuning, State& state, double squared_ratio,
                           double interval_s) noexcept;

}  // namespace odomd::estimator::full
