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

/// Covariance that an unobserved time of `gap_s` [s] adds to a pose: the car may have braked, sped
/// up or steered, σ = ½ a t², with a = 2 m/s² and 5 rad/s².
[[nodiscard]] inline Symmetric3 gap_noise(double gap_s) noexcept {
  const double half_square = 0.5 * gap_s * gap_s;
  const double position = 2.0 * half_square;
  const double yaw = 5.0 * half_square;
  return diagonal(position * position, position * position, yaw * yaw);
}

/// The same for the velocity: σ = a t.
[[nodiscard]] inline Symmetric3 velocity_gap_noise(double gap_s) noexcept {
  const double speed = 2.0 * gap_s;
  const double yaw_rate = 5.0 * gap_s;
  return diagonal(speed * speed, speed * speed, yaw_rate * yaw_rate);
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
