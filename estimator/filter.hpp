// The filter that a configuration chose, behind four calls. A value: copying one copies its whole
// state. No clock, no I/O, no heap: every call is real-time safe and noexcept.
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

/// One alternative per family of models. Another filter joins here, and in make_filter(). It may
/// keep a window of samples and fuse each at its own time within step(); the verdict of such a
/// sample is among the judgements of that step.
using Filter = std::variant<BaselineFilter, FullFilter>;

/// Settings of all models are one struct; each takes its own. Throws std::invalid_argument, naming
/// the setting, where a number is impossible.
[[nodiscard]] Filter make_filter(Model model, const FilterSettings& settings);

/// Sets the pose that the estimate starts from. Before this (or the first camera pose, where
/// `settings.initialise_from_camera`) step() returns estimates that are not initialised. A pose
/// that is not finite, or farther off than 10⁸ m, is none.
void set_initial_pose(Filter& filter, const Pose2& pose) noexcept;

/// Goes on from a predecessor's estimate that is `gap_s` old: its poses moved on at its velocity,
/// the covariance grown for the gap, the reset count raised by one. Initialised from the next step
/// on. False, and nothing done, where the estimate is not usable: not initialised, a model fault,
/// not finite, no positive definite covariance of the pose, a negative gap. Without a usable
/// covariance of the velocity the filter begins with its own.
bool resume(Filter& filter, const Estimate& predecessor, double gap_s) noexcept;

/// Hands a measurement in, in any order within a tick. It takes effect at the next step(). Nothing
/// where it is judged only then.
std::optional<Verdict> add(Filter& filter, const Measurement& measurement) noexcept;
std::optional<Verdict> add(Filter& filter, const CameraPose& pose) noexcept;

/// How the samples were judged that add() left open, of the last step. Valid until the next call.
[[nodiscard]] std::span<const Judgement> judgements(const Filter& filter) noexcept;

/// How noisy a source is by its own samples, at the last tick: of the model `full`, and of samples
/// of the sigma that FilterSettings states. Of the others nothing is estimated.
[[nodiscard]] SourceNoise noise(const Filter& filter, Source source) noexcept;

/// Whether a source tells the truth, at the last tick.
[[nodiscard]] SourceFlag flag(const Filter& filter, Source source) noexcept;

/// Advances to the tick that is valid at `tick_ns` and says what is believed there. Ticks that were
/// skipped are made up for with the inputs held, at most 200 of them (a second); for time beyond
/// that the covariance grows. A tick that is not at least half a period after the last one changes
/// nothing and returns the last estimate.
Estimate step(Filter& filter, std::int64_t tick_ns) noexcept;

}  // namespace odomd::estimator
