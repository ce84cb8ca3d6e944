// Squares and their sums, as variances are made of.
#pragma once

#include <cmath>

namespace odomd::estimator {

[[nodiscard]] constexpr double squared(double value) noexcept {
  return value * value;
}

/// √(Σ v²): the standard deviation of what errs by all of these, each for itself.
template <typename... Values>
[[nodiscard]] double root_of_squares(Values... values) noexcept {
  return std::sqrt((squared(values) + ...));
}

}  // namespace odomd::estimator
