// Variances and covariances. Those of (x, y, yaw) and of (v_x, v_y, ψ̇) are published packed, as
// the upper triangle by rows.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace odomd::estimator {

[[nodiscard]] constexpr double squared(double value) noexcept {
  return value * value;
}

/// √(Σ v²): standard deviation of a sum of independent errors.
template <typename... Values>
[[nodiscard]] double root_of_squares(Values... values) noexcept {
  return std::sqrt((squared(values) + ...));
}

/// A deviation of more sigmas than this is not noise.
inline constexpr double most_sigmas = 3.0;

inline constexpr double third = 1.0 / 3.0;

/// (0,0), (0,1), (0,2), (1,1), (1,2), (2,2); the packing of PoseCovariance.
using Symmetric3 = std::array<double, 6>;

[[nodiscard]] inline Symmetric3 packed(const Eigen::Matrix3d& m) noexcept {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}
[[nodiscard]] inline Eigen::Matrix3d unpacked(const Symmetric3& s) noexcept {
  return Eigen::Matrix3d{{s[0], s[1], s[2]}, {s[1], s[3], s[4]}, {s[2], s[4], s[5]}};
}

/// Rotates the first two axes by the angle with this cosine and sine.
[[nodiscard]] inline Eigen::Matrix3d rotation(double c, double s) noexcept {
  return Eigen::Matrix3d{{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}};
}
[[nodiscard]] inline Symmetric3 rotated(const Symmetric3& p, double c, double s) noexcept {
  const Eigen::Matrix3d R = rotation(c, s);
  return packed(R * unpacked(p) * R.transpose());
}

/// ∂(pose after the known displacement (dx, dy)) / ∂(pose before).
[[nodiscard]] inline Eigen::Matrix3d displacement(double dx, double dy) noexcept {
  return Eigen::Matrix3d{{1.0, 0.0, -dy}, {0.0, 1.0, dx}, {0.0, 0.0, 1.0}};
}

/// P = L Lᵀ. A NaN or infinity anywhere in P makes some element of L's diagonal not finite.
template <int Size>
[[nodiscard]] bool is_positive_definite(const Eigen::Matrix<double, Size, Size>& P) noexcept {
  const Eigen::LLT<Eigen::Matrix<double, Size, Size>> factors(P);
  return factors.info() == Eigen::Success && factors.matrixLLT().diagonal().allFinite();
}
[[nodiscard]] inline bool is_positive_definite(const Symmetric3& P) noexcept {
  return is_positive_definite(unpacked(P));
}

/// νᵀ S⁻¹ ν. Infinite if S is not positive definite or a number is not finite, so that the
/// comparison `<= gate` is false.
[[nodiscard]] inline double mahalanobis_squared(const Eigen::Matrix3d& S,
                                                const std::array<double, 3>& nu) noexcept {
  const Eigen::Vector3d v(nu.data());
  const double value = is_positive_definite(S) ? v.dot(S.llt().solve(v)) : HUGE_VAL;
  return std::isfinite(value) ? value : HUGE_VAL;
}

/// Variances are multiplied by this once per tick, which keeps a strongly correlated covariance
/// positive definite despite rounding. Adds 1.7 % per day.
inline constexpr double rounding_inflation = 1.0 + 1e-9;

/// D P D with the largest diagonal D ≤ 1 that limits the standard deviations; correlations stay.
template <int Size>
void limit(Eigen::Matrix<double, Size, Size>& P,
           const Eigen::Matrix<double, Size, 1>& largest) noexcept {
  for (Eigen::Index i = 0; i < Size; ++i) {
    if (P(i, i) > largest[i] * largest[i]) {
      const double factor = largest[i] / std::sqrt(P(i, i));
      P.row(i) *= factor;
      P.col(i) *= factor;
    }
  }
}

[[nodiscard]] inline bool is_finite(const Symmetric3& p) noexcept {
  return std::all_of(p.begin(), p.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace odomd::estimator
