// Compares one quantity from two sensors: whether they correlate, with which sign, and the factor
// by which they differ. The daemon compares the last pieces of a drive (wiring.hpp), and tools
// compare whole drives (tools/identify/common). No heap, no clock, no exceptions.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace odomd::daemon {

/// Weighted sums of pairs of values and of their products.
class Moments {
 public:
  /// Mean squares and mean product.
  struct Squares {
    double aa = 0.0, bb = 0.0, ab = 0.0;

    /// -1 to 1; 0 when one of the two has no signal.
    [[nodiscard]] double correlation() const noexcept {
      return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
    }
    /// rms of a / rms of b; 0 when b has no signal.
    [[nodiscard]] double gain() const noexcept { return bb > 0.0 ? std::sqrt(aa / bb) : 0.0; }
  };

  void add(double a, double b, double weight = 1.0) noexcept {
    n_ += weight;
    a_ += weight * a;
    b_ += weight * b;
    aa_ += weight * a * a;
    bb_ += weight * b * b;
    ab_ += weight * a * b;
  }
  void forget(double keep) noexcept {
    for (double* const sum : {&n_, &a_, &b_, &aa_, &bb_, &ab_}) *sum *= keep;
  }

  [[nodiscard]] double mean_a() const noexcept { return n_ > 0.0 ? a_ / n_ : 0.0; }
  [[nodiscard]] double mean_b() const noexcept { return n_ > 0.0 ? b_ / n_ : 0.0; }
  /// After removing as much of each mean as is allowed; all of it by default.
  [[nodiscard]] Squares squares(double offset_a = unlimited,
                                double offset_b = unlimited) const noexcept {
    if (n_ <= 0.0) return {};
    const double rest_a = mean_a() - std::clamp(mean_a(), -offset_a, offset_a);
    const double rest_b = mean_b() - std::clamp(mean_b(), -offset_b, offset_b);
    return {.aa = std::max(aa_ / n_ - mean_a() * mean_a(), 0.0) + rest_a * rest_a,
            .bb = std::max(bb_ / n_ - mean_b() * mean_b(), 0.0) + rest_b * rest_b,
            .ab = ab_ / n_ - mean_a() * mean_b() + rest_a * rest_b};
  }

 private:
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  double n_ = 0.0, a_ = 0.0, b_ = 0.0, aa_ = 0.0, bb_ = 0.0, ab_ = 0.0;
};

/// Moments with exponential forgetting. Ignores offsets of both sensors up to their bounds.
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
    const double keep = 1.0 - 1.0 / memory;
    pieces_ = keep * pieces_ + 1.0;
    moments_.forget(keep);
    moments_.add(a, b, 1.0 / (1.0 + (a * a + b * b) / (large * large)));
  }

  /// Whether there are enough pieces, and enough signal in b.
  [[nodiscard]] bool shows(const Bounds& bounds, double fewest) const noexcept {
    return pieces_ >= fewest && squares(bounds).bb >= bounds.least * bounds.least;
  }
  [[nodiscard]] Moments::Squares squares(const Bounds& bounds) const noexcept {
    return moments_.squares(bounds.offset_a, bounds.offset_b);
  }

 private:
  static constexpr double most = 1e9;    ///< keeps the squares finite
  static constexpr double usual = 10.0;  ///< multiple of `least`; larger values are rare

  double pieces_ = 0.0;
  Moments moments_;
};

}  // namespace odomd::daemon
