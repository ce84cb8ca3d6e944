// Checks that do not depend on a filter's state: rejects samples, poses and estimates that are not
// finite or beyond what any car can do.
#pragma once

#include <cmath>
#include <optional>

#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/predecessor.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

/// Throws std::invalid_argument with the setting's name if a number is impossible.
void require_possible(const FilterSettings& settings);

/// Beyond these a double no longer resolves a step [m] or a turn [rad].
inline constexpr double largest_coordinate = 1e8;
inline constexpr double largest_yaw = 1e6;

[[nodiscard]] inline bool is_possible(const Pose2& pose) noexcept {
  return std::abs(pose.yaw) <= largest_yaw && std::abs(pose.x) <= largest_coordinate &&
         std::abs(pose.y) <= largest_coordinate;
}

/// A smaller sigma would leave too few digits for the covariance.
inline constexpr double smallest_sigma = 1e-6;
inline constexpr double largest_camera_sigma = 1e3;  ///< [m, rad]

[[nodiscard]] constexpr double bounded_sigma(double sigma, double largest) noexcept {
  return std::clamp(sigma, smallest_sigma, largest);
}

/// Why a signal's sample is refused: source_off (the camera, or no source), non_finite, gated
/// (beyond physical_limit). Returns nothing if the sample is accepted.
[[nodiscard]] inline std::optional<Verdict> refusal(const Measurement& sample) noexcept {
  const std::size_t index = index_of(sample.source);
  if (index >= source_count || sample.source == Source::camera) {
    return Verdict::source_off;
  }
  if (!std::isfinite(sample.value) || !std::isfinite(sample.sigma) || sample.sigma < 0.0) {
    return Verdict::non_finite;
  }
  if (std::abs(sample.value) > physical_limit[index]) {
    return Verdict::gated;
  }
  return std::nullopt;
}

/// Whether a camera pose is finite and its standard deviations are positive.
[[nodiscard]] inline bool is_usable(const CameraPose& pose) noexcept {
  const auto is_sigma = [](double sigma) { return std::isfinite(sigma) && sigma > 0.0; };
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.yaw) &&
         is_sigma(pose.sigma_x) && is_sigma(pose.sigma_y) && is_sigma(pose.sigma_yaw);
}

/// Largest pose variance to resume from [m², rad²]; a larger one leaves too few digits for the
/// arithmetic.
inline constexpr double largest_resumed_variance = largest_yaw * largest_yaw;

/// Whether a filter can resume from an estimate that is `gap_s` [s] old: it is initialised, has no
/// model fault, a possible velocity and a positive definite covariance of the pose.
[[nodiscard]] inline bool may_resume(const Estimate& predecessor, double gap_s) noexcept {
  return predecessor.initialised && !predecessor.model_fault && gap_s >= 0.0 &&
         std::isfinite(gap_s) && is_possible(predecessor.map) && is_possible(predecessor.odom) &&
         is_possible(velocity_of(predecessor)) &&
         unpacked(predecessor.covariance).trace() <= largest_resumed_variance &&
         is_positive_definite(predecessor.covariance);
}

}  // namespace odomd::estimator
