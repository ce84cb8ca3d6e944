// Whether a source lies by far more off what the filter expects than its sigma and the filter's own
// say, and for seconds: by νᵀS⁻¹ν a degree of freedom, which is 1 where they are right.
//
// Only too much counts: a sigma that is stated too large is a choice.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// By the times of the samples and of the ticks alone.
class Consistency {
 public:
  /// A sample that was tested, gated or not; others are passed over.
  void take(const estimator::Judgement& judgement) noexcept {
    const double dt = static_cast<double>(judgement.time_ns - time_ns_) * 1e-9;
    if (judgement.degrees < 1 || dt <= 0.0) return;
    time_ns_ = judgement.time_ns;
    const double ratio = judgement.squared_ratio / judgement.degrees;
    const double bounded = std::isfinite(ratio) ? std::min(ratio, most) : most;
    // A pause is no time that it was large.
    const double counted_s = std::min(dt, longest_s);
    mean_ += (bounded - mean_) * (1.0 - std::exp(-counted_s / memory_s));
    large_s_ = mean_ < large ? 0.0 : large_s_ + counted_s;
  }

  /// Once a tick. `explained`: something else is known to be wrong, and the filter with it, so that
  /// it is no fault of this source.
  void look(std::int64_t now_ns, bool explained) noexcept {
    if (now_ns - time_ns_ > silent_ns) mean_ = 1.0;
    if (explained || mean_ < large) large_s_ = 0.0;
    if (explained || mean_ < small) inconsistent_ = false;
    if (large_s_ >= long_s) inconsistent_ = true;
  }

  [[nodiscard]] bool inconsistent() const noexcept { return inconsistent_; }

 private:
  static constexpr double most = 30.0;  ///< a sample that is wide of the mark is no scatter
  static constexpr double memory_s = 3.0, longest_s = 0.5;
  // No simulated drive and none for training is above 5.8 for so long; wheels of six times the
  // noise are.
  static constexpr double large = 7.0, small = 4.0;
  static constexpr double long_s = 5.0;
  static constexpr std::int64_t silent_ns = 5'000'000'000;  ///< then nothing is known any more

  double mean_ = 1.0;
  double large_s_ = 0.0;  ///< for so long
  std::int64_t time_ns_ = 0;
  bool inconsistent_ = false;
};

}  // namespace odomd::daemon
