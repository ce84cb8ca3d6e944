// Noise from the data: how noisy the inertial sensors are, at rest and on the move, and how
// restless what drives the filter's states is, by its innovations.
//
// docs/model.md, "Noise from the data".
#pragma once

#include "estimator/common/tuning.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

/// Sets the sigma of an inertial sensor's sample to what its samples scatter by: E (z_k - 2 z_k-1 +
/// z_k-2)² / 6, which motion hardly enters, of those at rest and of those on the move. From 0.1 to
/// 1 of the stated sigma at rest; on the move from 0.3 to 3, of a gyro to 1.
void measure_noise(const Tuning& tuning, State& state, Sample& sample) noexcept;

/// What is estimated by now of the noise of a source whose samples state the sigma `stated`.
[[nodiscard]] SourceNoise noise_of(const Tuning& tuning, const State& state, Source source,
                                   double stated) noexcept;

/// λ ← λ exp(τ/T p (ν² / (H P Hᵀ + R) - 1)), τ since the source's last sample, p the share that is
/// λ's: of a_x and of the wheel's own relative error by a wheel, of ε by the gyro. Once a sample,
/// fused or not.
void adapt_noise_scales(const Tuning& tuning, State& state, const Sample& sample,
                        const Prediction& z, const Innovation& nu) noexcept;

/// The same of the way's error, by a camera's pose `interval_s` after the one before.
void adapt_way_noise_scale(const Tuning& tuning, State& state, double squared_ratio,
                           double interval_s) noexcept;

}  // namespace odomd::estimator::full
