// Detects a source whose innovations are, for seconds, far larger than its sigma and the filter's
// covariance predict: νᵀS⁻¹ν per degree of freedom averages 1 when both are right.
//
// Only large innovations count: a sigma that is too large is the user's choice.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// Uses only the times of the samples and of the ticks.
class Consistency {
 public:
  /// Takes a sample that was tested, whether gated or not; ignores others.
  void take(const estimator::Judgement& judgement) noexcept {
    const double dt = static_cast<double>(judgement.time_ns - time_ns_) * 1e-9;
    if (judgement.degrees < 1 || dt <= 0.0) return;
    time_ns_ = judgement.time_ns;
    const double ratio = judgement.squared_ratio / judgement.degrees;
    const double bounded = std::isfinite(ratio) ? std::min(ratio, most) : most;
    // A pause does not count as time with large innovations.
    const double counted_s = std::min(dt, longest_s);
    mean_ += (bounded - mean_) * (1.0 - std::exp(-counted_s / memory_s));
    large_s_ = mean_ < large ? 0.0 : large_s_ + counted_s;
  }

  /// Call once per tick. `explained`: another fault is known that disturbs the filter, so this
  /// source is not to be reported.
  void update(std::int64_t now_ns, bool explained) noexcept {
    if (now_ns - time_ns_ > silent_ns) mean_ = 1.0;
    if (explained || mean_ < large) large_s_ = 0.0;
    if (explained || mean_ < small) inconsistent_ = false;
    if (large_s_ >= long_s) inconsistent_ = true;
  }

  [[nodiscard]] bool inconsistent() const noexcept { return inconsistent_; }

 private:
  static constexpr double most = 30.0;  ///< limits the weight of an outlier
  static constexpr double memory_s = 3.0, longest_s = 0.5;
  // No simulated or training drive exceeds 5.8 for long_s; wheels with six times the noise do.
  static constexpr double large = 7.0, small = 4.0;
  static constexpr double long_s = 5.0;
  static constexpr std::int64_t silent_ns = 5'000'000'000;  ///< after this pause the state is reset

  double mean_ = 1.0;
  double large_s_ = 0.0;  ///< how long the mean has been large
  std::int64_t time_ns_ = 0;
  bool inconsistent_ = false;
};

}  // namespace odomd::daemon
