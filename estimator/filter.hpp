// The configured filter behind a few functions. A value: a copy has the whole state. No clock, no
// I/O, no heap: every function is real-time safe and noexcept.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "estimator/baselines/baseline_filter.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/full_filter.hpp"

namespace odomd::estimator {

/// One alternative for each family of models. A new filter is added here and in make_filter(). It
/// may keep a window of samples and fuse each at its own time within step(), which then has its
/// judgement.
using Filter = std::variant<BaselineFilter, FullFilter>;

/// Each model uses its part of the settings. Throws std::invalid_argument with the setting's name
/// if a number is impossible.
[[nodiscard]] Filter make_filter(Model model, const FilterSettings& settings);

/// Sets the initial pose. Before this (or the first camera pose, with
/// `settings.initialise_from_camera`) the estimates of step() are not initialised. Ignores a pose
/// that is not finite or farther away than 10⁸ m.
void set_initial_pose(Filter& filter, const Pose2& pose) noexcept;

/// Resumes from a predecessor's estimate that is `gap_s` old: moves its poses on at its velocity,
/// grows the covariance for the gap, raises the reset count by one. The next step is initialised.
/// False, without an effect, if the estimate is not usable: not initialised, a model fault, not
/// finite, no positive definite covariance of the pose, or a negative gap. If the covariance of the
/// velocity is not usable, the filter starts with its own.
bool resume(Filter& filter, const Estimate& predecessor, double gap_s) noexcept;

/// Adds a sample, in any order within a tick. It takes effect at the next step(). Nothing if it is
/// judged only there.
std::optional<Verdict> add(Filter& filter, const Measurement& measurement) noexcept;
std::optional<Verdict> add(Filter& filter, const CameraPose& pose) noexcept;

/// Judgements of the last step for samples that add() left open. Valid until the next call.
[[nodiscard]] std::span<const Judgement> judgements(const Filter& filter) noexcept;

/// Measured noise of a source at the last tick, for samples with the sigma of FilterSettings. Only
/// the model `full` estimates it.
[[nodiscard]] SourceNoise noise(const Filter& filter, Source source) noexcept;

/// The integrity flag of a source at the last tick.
[[nodiscard]] SourceFlag flag(const Filter& filter, Source source) noexcept;

/// Advances to the tick at `tick_ns` and returns the estimate there. Skipped ticks are stepped
/// through with held inputs, at most 200 (a second); for a longer gap the covariance grows. A tick
/// less than half a period after the last one changes nothing and returns the last estimate.
Estimate step(Filter& filter, std::int64_t tick_ns) noexcept;

}  // namespace odomd::estimator
