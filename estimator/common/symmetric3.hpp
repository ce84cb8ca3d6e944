// Covariances of (x, y, yaw) and of (v_x, v_y, ψ̇): as matrices, and packed as the estimate has
// them.
#pragma once

#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace odomd::estimator {

/// The upper triangle by rows: (0,0), (0,1), (0,2), (1,1), (1,2), (2,2); as PoseCovariance.
using Symmetric3 = std::array<double, 6>;

[[nodiscard]] inline Symmetric3 packed(const Eigen::Matrix3d& m) noexcept {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}
[[nodiscard]] inline Eigen::Matrix3d unpacked(const Symmetric3& s) noexcept {
  return Eigen::Matrix3d{{s[0], s[1], s[2]}, {s[1], s[3], s[4]}, {s[2], s[4], s[5]}};
}

/// Covariance of independent errors of a position (or velocity), the same along x and y, and of a
/// yaw (or yaw rate): their standard deviations.
[[nodiscard]] inline Eigen::Matrix3d isotropic(double position, double yaw) noexcept {
  return Eigen::Vector3d(position, position, yaw).cwiseAbs2().asDiagonal();
}

/// R, which turns the first two axes by `yaw`.
[[nodiscard]] inline Eigen::Matrix3d rotation(double yaw) noexcept {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(yaw).toRotationMatrix();
  return R;
}

/// R P Rᵀ.
[[nodiscard]] inline Eigen::Matrix3d rotated(const Eigen::Matrix3d& P, double yaw) noexcept {
  const Eigen::Matrix3d R = rotation(yaw);
  return R * P * R.transpose();
}

/// F P Fᵀ with F = [1 0 -dy; 0 1 dx; 0 0 1]: the covariance of a pose after a known displacement
/// (dx, dy).
[[nodiscard]] inline Eigen::Matrix3d displaced(const Eigen::Matrix3d& P, double dx,
                                               double dy) noexcept {
  const Eigen::Matrix3d F{{1.0, 0.0, -dy}, {0.0, 1.0, dx}, {0.0, 0.0, 1.0}};
  return F * P * F.transpose();
}

/// νᵀ S⁻¹ ν. Infinite if S is not positive definite or a number is not finite, so that `<=` a gate
/// fails.
[[nodiscard]] inline double mahalanobis_squared(const Eigen::Matrix3d& S,
                                                const std::array<double, 3>& nu) noexcept {
  const Eigen::LLT<Eigen::Matrix3d> factors(S);
  const double value = factors.matrixL().solve(Eigen::Vector3d::Map(nu.data())).squaredNorm();
  return factors.info() == Eigen::Success && std::isfinite(value) ? value : HUGE_VAL;
}

[[nodiscard]] inline bool is_positive_definite(const Eigen::Matrix3d& S) noexcept {
  return S.allFinite() && mahalanobis_squared(S, {}) < HUGE_VAL;
}

/// D P D with the largest D = diag(a, b, c) ≤ 1 that limits the variances. Keeps P positive
/// definite, and the correlations.
[[nodiscard]] inline Eigen::Matrix3d limited(const Eigen::Matrix3d& P,
                                             const Eigen::Vector3d& limits) noexcept {
  const Eigen::Vector3d D = limits.cwiseQuotient(P.diagonal().cwiseMax(limits)).cwiseSqrt();
  return D.asDiagonal() * P * D.asDiagonal();
}

}  // namespace odomd::estimator
