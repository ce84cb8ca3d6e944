// Weighted least squares over the equations of all sources, or of all but some.
//
// docs/model.md, "Consensus".
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "estimator/common/measurement.hpp"

namespace odomd::estimator::integrity {

/// A set of sources, one bit each.
using Sources = std::uint32_t;

[[nodiscard]] constexpr Sources only(Source source) noexcept {
  return Sources{1} << index_of(source);
}

[[nodiscard]] constexpr bool contains(Sources sources, std::size_t source) noexcept {
  return (sources >> source & 1U) != 0;
}

inline constexpr Sources front_wheels =
    only(Source::wheel_front_left) | only(Source::wheel_front_right);
inline constexpr Sources rear_wheels = only(Source::wheel_rear_left) |
                                       only(Source::wheel_rear_right) | only(Source::wheel_rear) |
                                       only(Source::motor);
inline constexpr Sources wheels = front_wheels | rear_wheels;

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
  Motion sigma = Motion::Constant(unknown_speed);
  double misfit = 0.0;  ///< Σ ((z - aᵀ x) / σ)²
};

class Consensus {
 public:
  /// Prior knowledge, and one equation per source: two of the camera, none of the direction.
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
    // N = Σ a aᵀ / σ², b = Σ a z / σ², x = N⁻¹ b
    Eigen::Matrix<double, of::size, of::size> N = Eigen::Matrix<double, of::size, of::size>::Zero();
    Motion b = Motion::Zero();
    for (const Row& row : *this) {
      if ((row.sources & left_out) == 0) {
        const Motion weighed = row.by / (row.sigma * row.sigma);
        N += row.by * weighed.transpose();
        b += weighed * row.z;
      }
    }
    const Eigen::LLT<Eigen::Matrix<double, of::size, of::size>> factors(N);
    Solution solution;
    solution.motion = factors.solve(b);
    for (Eigen::Index i = 0; i < of::size; ++i) {
      solution.sigma[i] = std::sqrt(factors.solve(Motion::Unit(i))[i]);
    }
    for (const Row& row : *this) {
      if ((row.sources & left_out) == 0) {
        const double residual = row.off(solution.motion);
        solution.misfit += residual * residual;
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
