// Searches on an interval: by halving it, and by golden section.
#pragma once

namespace odomd::tools {

struct Interval {
  double low = 0.0, high = 0.0;

  [[nodiscard]] double middle() const { return 0.5 * (low + high); }
};

/// Halves the interval so many times, each time to the half in which a predicate that is true up to
/// some point becomes false.
template <class Predicate>
[[nodiscard]] Interval bisect(Interval range, int halvings, Predicate&& is_before) {
  for (int i = 0; i < halvings; ++i) {
    const double middle = range.middle();
    (is_before(middle) ? range.low : range.high) = middle;
  }
  return range;
}

/// Argument of the maximum of a unimodal function, to this width.
template <class Function>
[[nodiscard]] double argmax_unimodal(Function&& function, Interval range, double width) {
  constexpr double golden = 0.6180339887498949;
  const auto inner = [&range](double share) {
    return range.low + share * (range.high - range.low);
  };
  double a = inner(1.0 - golden), b = inner(golden);
  double at_a = function(a), at_b = function(b);
  while (range.high - range.low > width) {
    if (at_a < at_b) {
      range.low = a;
      a = b;
      at_a = at_b;
      at_b = function(b = inner(golden));
    } else {
      range.high = b;
      b = a;
      at_b = at_a;
      at_a = function(a = inner(1.0 - golden));
    }
  }
  return range.middle();
}

}  // namespace odomd::tools
