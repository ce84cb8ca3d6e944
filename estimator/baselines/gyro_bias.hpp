// The gyro's bias, averaged while the car stands: mean and variance of a constant. A reading counts
// if the car has stood for a while before and after it, as it still slows down when its wheels read
// zero, and sets off before they read more. Each has the same weight, so a stretch counts by its
// length.
#pragma once

#include <cstdint>
#include <utility>

#include "estimator/baselines/signals.hpp"
#include "estimator/common/squares.hpp"
#include "estimator/common/time.hpp"
#include "estimator/common/tuning.hpp"

namespace odomd::estimator {

class GyroBias {
 public:
  explicit GyroBias(const Tuning& tuning) noexcept
      : walk_(squared(tuning.gyro_bias_walk)), variance_(squared(tuning.gyro_bias)) {}

  /// Takes a reading in. The car stands if no wheel turns and the gyro is quiet: within its noise
  /// and the uncertainty of the bias.
  void add(const HeldSignal& gyro, bool wheels_still) noexcept;

  [[nodiscard]] double value() const noexcept { return value_; }        ///< [rad/s]
  [[nodiscard]] double variance() const noexcept { return variance_; }  ///< [rad²/s²]

 private:
  struct Block {
    std::int64_t since_ns = 0;
    double sum = 0.0;
    int readings = 0;
  };
  static constexpr double block_s = 0.3;
  static constexpr double quiet_ratio = 16.0;  ///< ν²/S: 4 σ

  double walk_;  ///< of the variance, per second
  double value_ = 0.0;
  double variance_;
  Block block_, before_;  ///< the one that fills, and the complete one before it
  int complete_ = 0;      ///< blocks since the car stands
  std::int64_t averaged_ns_ = 0;
};

inline void GyroBias::add(const HeldSignal& gyro, bool wheels_still) noexcept {
  const double noise = squared(gyro.sigma);
  if (!wheels_still || squared(gyro.value - value_) > quiet_ratio * (variance_ + noise)) {
    complete_ = 0;
    block_ = {};
    return;
  }
  if (block_.readings == 0) {
    block_.since_ns = gyro.time_ns;
  }
  block_.sum += gyro.value;
  ++block_.readings;
  if (seconds_between(block_.since_ns, gyro.time_ns) < block_s) {
    return;
  }
  const Block block = std::exchange(before_, std::exchange(block_, {}));
  if (++complete_ < 3) {
    return;  // the block before the last needs one before it
  }
  if (averaged_ns_ != 0) {
    variance_ += walk_ * seconds_between(averaged_ns_, gyro.time_ns);
  }
  averaged_ns_ = gyro.time_ns;
  // K = P / (P + R / n),  b ← b + K ν,  P ← (1 - K) P
  const double gain = variance_ / (variance_ + noise / block.readings);
  value_ += gain * (block.sum / block.readings - value_);
  variance_ -= gain * variance_;
}

}  // namespace odomd::estimator
