// Extrapolates the last estimate of an ended filter, so that a new filter can resume from it.
#pragma once

#include <cmath>
#include <cstdint>

#include "estimator/common/estimate.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

/// Longer gaps between ticks are not stepped through: the covariance grows instead.
inline constexpr std::int64_t max_bridged_ticks = 200;

/// Assumed braking, acceleration and steering while the car is not observed [m/s², rad/s²].
inline constexpr double unobserved_accel = 2.0;
inline constexpr double unobserved_yaw_accel = 5.0;

/// Variances of (x, y, yaw) or of their rates due to these accelerations a: σ = `factor` a. In an
/// unobserved time τ [s], a adds σ = a τ to the velocity and σ = ½ a τ² to the pose.
[[nodiscard]] inline Eigen::Vector3d gap_noise(double factor) noexcept {
  return (factor * Eigen::Vector3d(unobserved_accel, unobserved_accel, unobserved_yaw_accel))
      .cwiseAbs2();
}

[[nodiscard]] inline BodyVelocity velocity_of(const Estimate& estimate) noexcept {
  return {estimate.v_x, estimate.v_y, estimate.yaw_rate};
}

/// A usable predecessor (integrity/admission.hpp) extrapolated over a gap of `gap_s` [s] with its
/// velocity, whose error is constant over the gap τ:
///
///   P ← F P Fᵀ + τ² G V Gᵀ + gap_noise(½ τ²), V ← V + gap_noise(τ).
///
/// If the predecessor's V is not positive definite, or larger than any car's, it is first replaced
/// with the V of a new filter, (1 m/s)² and (1 rad/s)².
[[nodiscard]] inline Estimate after_gap(const Estimate& predecessor, double gap_s) noexcept {
  Estimate e = predecessor;
  const BodyVelocity velocity = velocity_of(predecessor);
  e.map = moved(predecessor.map, velocity, gap_s);
  e.odom = moved(predecessor.odom, velocity, gap_s);

  constexpr double most = 2.0 * fastest * fastest + fastest_turn * fastest_turn;
  Eigen::Matrix3d V = unpacked(predecessor.velocity_covariance);
  if (!is_positive_definite(V) || V.trace() > most) {
    V.setIdentity();
  }
  const Eigen::Matrix3d F = displacement(e.map.x - predecessor.map.x, e.map.y - predecessor.map.y);
  const Eigen::Matrix3d R = rotation(std::cos(predecessor.map.yaw), std::sin(predecessor.map.yaw));
  Eigen::Matrix3d P = F * unpacked(predecessor.covariance) * F.transpose() +
                      gap_s * gap_s * (R * V * R.transpose());
  P.diagonal() += gap_noise(0.5 * gap_s * gap_s);
  V.diagonal() += gap_noise(gap_s);
  e.covariance = packed(P);
  e.velocity_covariance = packed(V);
  return e;
}

}  // namespace odomd::estimator
