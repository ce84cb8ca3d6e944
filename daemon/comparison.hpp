// One quantity as two sensors say it: how alike they are, and by which factor they differ, over the
// last pieces of a drive.
#pragma once

#include <algorithm>
#include <cmath>

namespace odomd::daemon {

/// Running sums that forget. An offset of each sensor, within its bound, counts for nothing.
class Comparison {
 public:
  struct Bounds {
    double offset_a = 0.0;
    double offset_b = 0.0;
    double least = 0.0;  ///< rms of b below which nothing shows
  };

  /// A piece that is `memory` pieces old counts by 1/e.
  void add(double a, double b, double memory) noexcept {
    const double keep = 1.0 - 1.0 / memory;
    n_ = keep * n_ + 1.0;
    a_ = keep * a_ + a;
    b_ = keep * b_ + b;
    aa_ = keep * aa_ + a * a;
    bb_ = keep * bb_ + b * b;
    ab_ = keep * ab_ + a * b;
  }

  /// Enough pieces, and enough in b.
  [[nodiscard]] bool shows(const Bounds& bounds, double fewest) const noexcept {
    return n_ >= fewest && sums(bounds).bb >= bounds.least * bounds.least;
  }

  /// -1 to 1; 0 where one of them says nothing.
  [[nodiscard]] double correlation(const Bounds& bounds) const noexcept {
    const Sums s = sums(bounds);
    return s.aa > 0.0 && s.bb > 0.0 ? s.ab / std::sqrt(s.aa * s.bb) : 0.0;
  }

  /// |a| over |b|.
  [[nodiscard]] double gain(const Bounds& bounds) const noexcept {
    const Sums s = sums(bounds);
    return s.bb > 0.0 ? std::sqrt(s.aa / s.bb) : 0.0;
  }

 private:
  struct Sums {
    double aa = 0.0, bb = 0.0, ab = 0.0;
  };

  // Mean squares about the offsets that leave least of the means.
  [[nodiscard]] Sums sums(const Bounds& bounds) const noexcept {
    if (n_ <= 0.0) return {};
    const double mean_a = a_ / n_, mean_b = b_ / n_;
    const double rest_a = mean_a - std::clamp(mean_a, -bounds.offset_a, bounds.offset_a);
    const double rest_b = mean_b - std::clamp(mean_b, -bounds.offset_b, bounds.offset_b);
    return {.aa = std::max(aa_ / n_ - mean_a * mean_a, 0.0) + rest_a * rest_a,
            .bb = std::max(bb_ / n_ - mean_b * mean_b, 0.0) + rest_b * rest_b,
            .ab = ab_ / n_ - mean_a * mean_b + rest_a * rest_b};
  }

  double n_ = 0.0, a_ = 0.0, b_ = 0.0, aa_ = 0.0, bb_ = 0.0, ab_ = 0.0;
};

}  // namespace odomd::daemon
