// Searches on an interval by bisection.
#pragma once

namespace odomd::tools {

struct Interval {
  double low = 0.0, high = 0.0;

  [[nodiscard]] double middle() const { return 0.5 * (low + high); }
};

/// Bisects `halvings` times, keeping the half in which the predicate changes from true to false.
template <class Predicate>
[[nodiscard]] Interval bisect(Interval range, int halvings, Predicate&& is_before) {
  for (int i = 0; i < halvings; ++i) {
    const double middle = range.middle();
    (is_before(middle) ? range.low : range.high) = middle;
  }
  return range;
}

/// Argument of the maximum of a smooth unimodal function: the point where it starts to fall.
template <class Function>
[[nodiscard]] double argmax_unimodal(Function&& function, Interval range, int halvings) {
  const double h = 0.01 * (range.high - range.low);
  return bisect(range, halvings, [&](double x) { return function(x + h) > function(x - h); })
      .middle();
}

}  // namespace odomd::tools
