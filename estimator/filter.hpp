// The configured filter behind a few functions. A value: a copy has the whole state. No clock, no
// I/O, no heap: every function is real-time safe and noexcept.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <variant>

#include "estimator/baselines/baseline_filter.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/full_filter.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator {

/// One alternative for each family of models. A new filter is added here and in make_filter(). A
/// filter may keep a window of samples and fuse each sample at its own time within step();
/// judgements() then returns the sample's verdict.
using Filter = std::variant<BaselineFilter, FullFilter>;

/// Each model uses its part of the settings. Throws std::invalid_argument with the setting's name
/// if a number is impossible.
[[nodiscard]] inline Filter make_filter(Model model, const FilterSettings& settings) {
  require_possible(settings);
  if (static_cast<std::size_t>(model) >= model_names.size()) {
    throw std::invalid_argument("no such model");
  }
  return model == Model::full ? Filter(std::in_place_type<FullFilter>, settings)
                              : Filter(std::in_place_type<BaselineFilter>, model, settings);
}

/// Sets the initial pose. Before this (or the first camera pose, with
/// `settings.initialise_from_camera`) the estimates of step() are not initialised. Ignores a pose
/// that is not finite or farther away than 10⁸ m.
inline void set_initial_pose(Filter& filter, const Pose2& pose) noexcept {
  std::visit([&](auto& f) { f.set_initial_pose(pose); }, filter);
}

/// Resumes from a predecessor's estimate that is `gap_s` old: extrapolates its poses with its
/// velocity, grows the covariance for the gap, raises the reset count by one. The next step is
/// initialised. Returns false, without an effect, if the estimate is not usable: not initialised, a
/// model fault, not finite, no positive definite covariance of the pose, or a negative gap. If the
/// covariance of the velocity is not usable, the filter starts with its own.
inline bool resume(Filter& filter, const Estimate& predecessor, double gap_s) noexcept {
  return std::visit([&](auto& f) { return f.resume(predecessor, gap_s); }, filter);
}

/// Adds a sample, in any order within a tick. It takes effect at the next step(). Returns nothing
/// if the sample is judged only in that step.
template <typename MeasurementOrPose>
std::optional<Verdict> add(Filter& filter, const MeasurementOrPose& sample) noexcept {
  return std::visit([&](auto& f) -> std::optional<Verdict> { return f.add(sample); }, filter);
}

/// Judgements of the last step for samples that add() left open. Valid until the next call.
[[nodiscard]] inline std::span<const Judgement> judgements(const Filter& filter) noexcept {
  const auto* const full = std::get_if<FullFilter>(&filter);
  return full != nullptr ? full->judgements() : std::span<const Judgement>();
}

/// Measured noise of a source at the last tick, for samples with the sigma of FilterSettings. Only
/// the model `full` estimates it.
[[nodiscard]] inline SourceNoise noise(const Filter& filter, Source source) noexcept {
  const auto* const full = std::get_if<FullFilter>(&filter);
  return full != nullptr ? full->noise(source) : SourceNoise();
}

/// The integrity flag of a source at the last tick.
[[nodiscard]] inline SourceFlag flag(const Filter& filter, Source source) noexcept {
  return std::visit([&](const auto& f) { return f.flag(source); }, filter);
}

/// Advances to the tick at `tick_ns` and returns the estimate there. Skipped ticks are stepped
/// through with held inputs, at most 200 (a second); for a longer gap the covariance grows. A tick
/// less than half a period after the last one changes nothing and returns the last estimate.
inline Estimate step(Filter& filter, std::int64_t tick_ns) noexcept {
  return std::visit([&](auto& f) { return f.step(tick_ns); }, filter);
}

}  // namespace odomd::estimator
