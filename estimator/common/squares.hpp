// Helpers for variances.
#pragma once

#include <cmath>

namespace odomd::estimator {

[[nodiscard]] constexpr double squared(double value) noexcept {
  return value * value;
}

/// Multiplies variances once a tick, which keeps a strongly correlated covariance positive definite
/// in spite of rounding; 1.7 % a day.
inline constexpr double rounding_inflation = 1.0 + 1e-9;

/// √(Σ v²): standard deviation of a sum of independent errors.
template <typename... Values>
[[nodiscard]] double root_of_squares(Values... values) noexcept {
  return std::sqrt((squared(values) + ...));
}

}  // namespace odomd::estimator
