// Bisection.
#pragma once

namespace odomd::tools {

/// The point in [low, high] where the predicate becomes false, by bisection with `halvings` steps.
template <class Predicate>
[[nodiscard]] double bisect(double low, double high, int halvings, Predicate&& is_before) {
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (is_before(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace odomd::tools
