// Moves the last estimate of an ended filter on, so that a new filter can resume from it.
#pragma once

#include <cmath>
#include <cstdint>

#include "estimator/common/estimate.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

/// A longer gap between ticks is not stepped through: the covariance grows instead.
inline constexpr std::int64_t max_bridged_ticks = 200;

/// How a driver brakes, speeds up or steers while nobody observes it [m/s², rad/s²].
inline constexpr double unobserved_accel = 2.0;
inline constexpr double unobserved_yaw_accel = 5.0;

/// Covariance that an unobserved time of `gap_s` [s] adds to a pose: σ = ½ a t².
[[nodiscard]] inline Symmetric3 gap_noise(double gap_s) noexcept {
  const double half_square = 0.5 * gap_s * gap_s;
  return isotropic(unobserved_accel * half_square, unobserved_yaw_accel * half_square);
}

/// The same for the velocity: σ = a t.
[[nodiscard]] inline Symmetric3 velocity_gap_noise(double gap_s) noexcept {
  return isotropic(unobserved_accel * gap_s, unobserved_yaw_accel * gap_s);
}

[[nodiscard]] inline BodyVelocity velocity_of(const Estimate& estimate) noexcept {
  return {estimate.v_x, estimate.v_y, estimate.yaw_rate};
}

/// A usable predecessor (integrity/admission.hpp) after a gap of `gap_s` [s], at its velocity,
/// whose error lasts as long as the gap:
///
///   P ← F P Fᵀ + τ² G V Gᵀ + gap_noise, V ← V + velocity_gap_noise.
///
/// If its V is not positive definite, or larger than any car's, V is that of a new filter,
/// (1 m/s)² and (1 rad/s)².
[[nodiscard]] inline Estimate after_gap(const Estimate& predecessor, double gap_s) noexcept {
  Estimate e = predecessor;
  const BodyVelocity velocity = velocity_of(predecessor);
  e.map = moved(predecessor.map, velocity, gap_s);
  e.odom = moved(predecessor.odom, velocity, gap_s);

  constexpr double most = 2.0 * fastest * fastest + fastest_turn * fastest_turn;
  const Symmetric3& given = predecessor.velocity_covariance;
  const bool usable =
      is_finite(given) && given[0] + given[3] + given[5] <= most && is_positive_definite(given);
  const Symmetric3 V = usable ? given : diagonal(1.0, 1.0, 1.0);
  const double c = std::cos(predecessor.map.yaw);
  const double s = std::sin(predecessor.map.yaw);
  const Symmetric3 P = sum(
      displaced(predecessor.covariance, e.map.x - predecessor.map.x, e.map.y - predecessor.map.y),
      scaled(rotated(V, c, s), gap_s * gap_s));
  e.covariance = sum(P, gap_noise(gap_s));
  e.velocity_covariance = sum(V, velocity_gap_noise(gap_s));
  return e;
}

}  // namespace odomd::estimator
