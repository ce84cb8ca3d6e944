// Whether a source scatters about what the filter expects by far more than its sigma and the
// filter's own say, and for seconds: by νᵀS⁻¹ν a degree of freedom, which is 1 where they are
// right.
//
// Only too much counts: a sigma that is stated too large is a choice.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// By the times of the samples alone.
class Consistency {
 public:
  /// A sample that was tested, gated or not; others are passed over.
  void take(const estimator::Judgement& judgement) noexcept {
    const double dt = static_cast<double>(judgement.time_ns - time_ns_) * 1e-9;
    if (judgement.degrees < 1 || dt <= 0.0) return;
    time_ns_ = judgement.time_ns;
    const double ratio = judgement.squared_ratio / judgement.degrees;
    const double bounded = std::isfinite(ratio) ? std::min(ratio, most) : most;
    mean_ += (bounded - mean_) * (1.0 - std::exp(-std::min(dt, longest_s) / memory_s));
    if (mean_ < large) calm_ns_ = time_ns_;
    if (mean_ < small) inconsistent_ = false;
    if (time_ns_ - calm_ns_ >= long_ns) inconsistent_ = true;
  }

  [[nodiscard]] bool inconsistent() const noexcept { return inconsistent_; }

 private:
  static constexpr double most = 30.0;  ///< a sample that is wide of the mark is no scatter
  static constexpr double memory_s = 3.0, longest_s = 0.5;
  // No simulated drive and none for training is above 5.8 for so long; six times the noise is.
  static constexpr double large = 7.0, small = 4.0;
  static constexpr std::int64_t long_ns = 5'000'000'000;

  double mean_ = 1.0;
  std::int64_t time_ns_ = 0;
  std::int64_t calm_ns_ = 0;  ///< when it was not large last
  bool inconsistent_ = false;
};

}  // namespace odomd::daemon
