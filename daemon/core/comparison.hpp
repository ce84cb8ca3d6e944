// Compares one quantity from two sensors: their correlation, and the factor by which they differ,
// over the last pieces of a drive.
#pragma once

#include <algorithm>
#include <cmath>

namespace odomd::daemon {

/// Running sums with exponential forgetting. An offset of either sensor is ignored up to its bound.
class Comparison {
 public:
  struct Bounds {
    double offset_a = 0.0;
    double offset_b = 0.0;
    double least = 0.0;  ///< rms of b below which there is no result
  };

  /// A piece that is `memory` pieces old has the weight 1/e. Large values get less weight, so that
  /// a wrong unit is forgotten as quickly as a wrong sign.
  void add(double a, double b, const Bounds& bounds, double memory) noexcept {
    a = std::clamp(a, -most, most);
    b = std::clamp(b, -most, most);
    const double large = usual * bounds.least;
    const double weight = 1.0 / (1.0 + (a * a + b * b) / (large * large));
    const double keep = 1.0 - 1.0 / memory;
    pieces_ = keep * pieces_ + 1.0;
    n_ = keep * n_ + weight;
    a_ = keep * a_ + weight * a;
    b_ = keep * b_ + weight * b;
    aa_ = keep * aa_ + weight * a * a;
    bb_ = keep * bb_ + weight * b * b;
    ab_ = keep * ab_ + weight * a * b;
  }

  /// Whether there are enough pieces, and enough signal in b.
  [[nodiscard]] bool shows(const Bounds& bounds, double fewest) const noexcept {
    return pieces_ >= fewest && sums(bounds).bb >= bounds.least * bounds.least;
  }

  /// -1 to 1; 0 when one of the two has no signal.
  [[nodiscard]] double correlation(const Bounds& bounds) const noexcept {
    const Sums s = sums(bounds);
    return s.aa > 0.0 && s.bb > 0.0 ? s.ab / std::sqrt(s.aa * s.bb) : 0.0;
  }

  /// rms of a / rms of b.
  [[nodiscard]] double gain(const Bounds& bounds) const noexcept {
    const Sums s = sums(bounds);
    return s.bb > 0.0 ? std::sqrt(s.aa / s.bb) : 0.0;
  }

 private:
  struct Sums {
    double aa = 0.0, bb = 0.0, ab = 0.0;
  };

  // Mean squares and mean product of a and b, after removing as much offset as the bounds allow.
  [[nodiscard]] Sums sums(const Bounds& bounds) const noexcept {
    if (n_ <= 0.0) return {};
    const double mean_a = a_ / n_, mean_b = b_ / n_;
    const double rest_a = mean_a - std::clamp(mean_a, -bounds.offset_a, bounds.offset_a);
    const double rest_b = mean_b - std::clamp(mean_b, -bounds.offset_b, bounds.offset_b);
    return {.aa = std::max(aa_ / n_ - mean_a * mean_a, 0.0) + rest_a * rest_a,
            .bb = std::max(bb_ / n_ - mean_b * mean_b, 0.0) + rest_b * rest_b,
            .ab = ab_ / n_ - mean_a * mean_b + rest_a * rest_b};
  }

  static constexpr double most = 1e9;    ///< keeps the squares finite
  static constexpr double usual = 10.0;  ///< multiple of `least`; larger values are rare

  double pieces_ = 0.0;
  double n_ = 0.0, a_ = 0.0, b_ = 0.0, aa_ = 0.0, bb_ = 0.0, ab_ = 0.0;
};

}  // namespace odomd::daemon
