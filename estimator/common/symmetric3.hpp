// Symmetric 3x3 matrices, packed: the upper triangle by rows. For covariances of (x, y, yaw) and of
// (v_x, v_y, ψ̇), which then stay symmetric.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Core>

namespace odomd::estimator {

/// (0,0), (0,1), (0,2), (1,1), (1,2), (2,2); the packing of PoseCovariance.
using Symmetric3 = std::array<double, 6>;

[[nodiscard]] inline Symmetric3 packed(const Eigen::Matrix3d& m) noexcept {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}
[[nodiscard]] inline Eigen::Matrix3d unpacked(const Symmetric3& s) noexcept {
  return Eigen::Matrix3d{{s[0], s[1], s[2]}, {s[1], s[3], s[4]}, {s[2], s[4], s[5]}};
}

[[nodiscard]] constexpr Symmetric3 diagonal(double a, double b, double c) noexcept {
  return {a, 0.0, 0.0, b, 0.0, c};
}

/// Covariance of independent errors of a position (or velocity), the same along x and y, and of a
/// yaw (or yaw rate): their standard deviations.
[[nodiscard]] constexpr Symmetric3 isotropic(double position, double yaw) noexcept {
  return diagonal(position * position, position * position, yaw * yaw);
}

[[nodiscard]] constexpr Symmetric3 scaled(const Symmetric3& m, double factor) noexcept {
  return {m[0] * factor, m[1] * factor, m[2] * factor, m[3] * factor, m[4] * factor, m[5] * factor};
}

[[nodiscard]] constexpr Symmetric3 sum(const Symmetric3& a, const Symmetric3& b) noexcept {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]};
}

/// R P Rᵀ, R the rotation of the first two axes by the angle with this cosine and sine.
[[nodiscard]] constexpr Symmetric3 rotated(const Symmetric3& p, double c, double s) noexcept {
  return {c * c * p[0] - 2.0 * c * s * p[1] + s * s * p[3],
          c * s * (p[0] - p[3]) + (c * c - s * s) * p[1],
          c * p[2] - s * p[4],
          s * s * p[0] + 2.0 * c * s * p[1] + c * c * p[3],
          s * p[2] + c * p[4],
          p[5]};
}

/// F P Fᵀ with F = [1 0 -dy; 0 1 dx; 0 0 1]: the covariance of a pose after a known displacement
/// (dx, dy).
[[nodiscard]] constexpr Symmetric3 displaced(const Symmetric3& p, double dx, double dy) noexcept {
  return {p[0] - 2.0 * dy * p[2] + dy * dy * p[5],
          p[1] + dx * p[2] - dy * p[4] - dx * dy * p[5],
          p[2] - dy * p[5],
          p[3] + 2.0 * dx * p[4] + dx * dx * p[5],
          p[4] + dx * p[5],
          p[5]};
}

/// νᵀ S⁻¹ ν. Infinite if S is not positive definite or a number is not finite, so that `<=` a gate
/// fails.
[[nodiscard]] inline double mahalanobis_squared(const Symmetric3& s,
                                                const std::array<double, 3>& nu) noexcept {
  // S = L D Lᵀ, L with ones on its diagonal. D is positive if and only if S is positive definite;
  // it keeps more digits than the minors of S.
  const double d0 = s[0];
  const double l10 = s[1] / d0;
  const double l20 = s[2] / d0;
  const double d1 = s[3] - l10 * s[1];
  const double l21 = (s[4] - l20 * s[1]) / d1;
  const double d2 = s[5] - l20 * s[2] - l21 * l21 * d1;
  // y = L⁻¹ ν, νᵀ S⁻¹ ν = Σ y² / d
  const double y0 = nu[0];
  const double y1 = nu[1] - l10 * y0;
  const double y2 = nu[2] - l20 * y0 - l21 * y1;
  const double value = y0 * y0 / d0 + y1 * y1 / d1 + y2 * y2 / d2;
  return d0 > 0.0 && d1 > 0.0 && d2 > 0.0 && std::isfinite(value) ? value : HUGE_VAL;
}

[[nodiscard]] inline bool is_positive_definite(const Symmetric3& s) noexcept {
  return mahalanobis_squared(s, {}) < HUGE_VAL;
}

/// D P D with the largest D = diag(a, b, c) ≤ 1 that limits the variances. Keeps P positive
/// definite, and the correlations.
[[nodiscard]] inline Symmetric3 limited(const Symmetric3& p,
                                        const std::array<double, 3>& limits) noexcept {
  const auto factor = [](double variance, double limit) {
    return variance > limit ? std::sqrt(limit / variance) : 1.0;
  };
  const double a = factor(p[0], limits[0]);
  const double b = factor(p[3], limits[1]);
  const double c = factor(p[5], limits[2]);
  return {a * a * p[0], a * b * p[1], a * c * p[2], b * b * p[3], b * c * p[4], c * c * p[5]};
}

[[nodiscard]] inline bool is_finite(const Symmetric3& p) noexcept {
  return std::all_of(p.begin(), p.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace odomd::estimator
