// Squares, and roots of their sums.
#pragma once

#include <cmath>

namespace odomd::estimator {

[[nodiscard]] constexpr double squared(double value) noexcept {
  return value * value;
}

/// √(Σ v²): standard deviation of a sum of independent errors.
template <typename... Values>
[[nodiscard]] double root_of_squares(Values... values) noexcept {
  return std::sqrt((squared(values) + ...));
}

}  // namespace odomd::estimator
