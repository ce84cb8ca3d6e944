// Weighted least squares over the equations of all sources, or without some of them.
//
// docs/model.md, "Consensus".
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>
#include <Eigen/LU>

#include "estimator/common/measurement.hpp"
#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator::integrity {

inline constexpr Sources front_wheels = set_of(is_front);
inline constexpr Sources rear_wheels = wheels & ~front_wheels;

/// The unknowns: speed [m/s] and yaw rate [rad/s] of the car, and the slip of front and rear wheels
/// [m/s].
namespace of {
enum Index : Eigen::Index { speed, yaw_rate, front_slip, rear_slip, size };
}  // namespace of

using Motion = Eigen::Matrix<double, of::size, 1>;

/// aᵀ x = z, with the standard deviation of z.
struct Row {
  Sources sources = 0;  ///< sources that this equation uses; 0: prior knowledge
  Motion by = Motion::Zero();
  double z = 0.0;
  double sigma = 1.0;

  [[nodiscard]] double off(const Motion& x) const noexcept { return (z - by.dot(x)) / sigma; }
};

/// Sigma before any equation: larger than any car's speed [m/s, rad/s].
inline constexpr double unknown_speed = 100.0;

struct Solution {
  Motion motion = Motion::Zero();
  Eigen::Vector2d sigma = Eigen::Vector2d::Constant(unknown_speed);  ///< of speed and yaw rate
  double misfit = 0.0;                                               ///< Σ ((z - aᵀ x) / σ)²
};

class Consensus {
 public:
  /// Prior knowledge, and one equation per source, but two for the camera and none for
  /// the direction.
  static constexpr std::size_t capacity = of::size + source_count;

  void add(const Row& row) noexcept {
    if (count_ < capacity) {
      rows_[count_++] = row;
      present_ |= row.sources;
    }
  }
  /// All sources with an equation.
  [[nodiscard]] Sources present() const noexcept { return present_; }
  /// Least squares over all rows that use no source of `left_out`. The rows without a source must
  /// make the solution unique.
  [[nodiscard]] Solution without(Sources left_out) const noexcept {
    // N = Σ a aᵀ / σ², b = Σ a z / σ², N x = b
    Eigen::Matrix<double, of::size, of::size> N = Eigen::Matrix<double, of::size, of::size>::Zero();
    Motion b = Motion::Zero();
    for (const Row& row : *this) {
      if ((row.sources & left_out) == 0) {
        const Motion weighed = 1.0 / squared(row.sigma) * row.by;
        N += row.by * weighed.transpose();
        b += weighed * row.z;
      }
    }
    // No row has both slips, so their block D of N = [A Bᵀ; B D] is diagonal: P = (A - Bᵀ D⁻¹ B)⁻¹.
    const auto B = N.bottomLeftCorner<2, 2>();
    const Eigen::Vector2d per_slip = N.diagonal().tail<2>().cwiseInverse();
    const Eigen::Matrix2d C = B.transpose() * per_slip.asDiagonal();
    const Eigen::Matrix2d P = (N.topLeftCorner<2, 2>() - C * B).inverse();
    Solution solution;
    solution.motion.head<2>() = P * (b.head<2>() - C * b.tail<2>());
    solution.motion.tail<2>() = per_slip.cwiseProduct(b.tail<2>() - B * solution.motion.head<2>());
    solution.sigma = P.diagonal().cwiseSqrt();
    for (const Row& row : *this) {
      if ((row.sources & left_out) == 0) {
        solution.misfit += squared(row.off(solution.motion));
      }
    }
    return solution;
  }

  [[nodiscard]] const Row* begin() const noexcept { return rows_.data(); }
  [[nodiscard]] const Row* end() const noexcept { return rows_.data() + count_; }

 private:
  std::array<Row, capacity> rows_{};
  std::size_t count_ = 0;
  Sources present_ = 0;
};

}  // namespace odomd::estimator::integrity
