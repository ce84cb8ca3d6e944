// The signals of models without a window: the newest value of each, held until the next one, and
// v_x from the available wheel speeds. The newest value has the latest sample time, whatever the
// order of arrival.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/common/tuning.hpp"

namespace odomd::estimator {

/// The newest sample of a source; value 0 and the default sigma before the first.
struct HeldSignal {
  bool seen = false;
  std::int64_t time_ns = 0;
  double value = 0.0;
  double sigma = 0.0;  ///< limited to the source's physical_limit
};

class HeldSignals {
 public:
  explicit HeldSignals(const FilterSettings& settings) noexcept;

  /// Holds a sample, or returns why not: non_finite, future (after `latest_ns`), gated (beyond
  /// physical_limit), duplicate, too_old (older than the held sample). Not for camera poses.
  Verdict take(const Measurement& sample, std::int64_t latest_ns) noexcept;

  [[nodiscard]] const HeldSignal& operator[](Source source) const noexcept {
    return held_[index_of(source)];
  }
  /// Whether a wheel has a sample within half a second before the newest wheel sample.
  [[nodiscard]] bool alive(Source wheel) const noexcept;
  /// Whether all live wheels are slower than 2 sigma (clamped to 0.01 ... 0.03 m/s).
  /// False if no wheel is alive.
  [[nodiscard]] bool wheels_still() const noexcept;

 private:
  std::array<HeldSignal, source_count> held_{};
  std::array<double, source_count> sigma_;
  std::int64_t newest_wheel_ns_ = std::numeric_limits<std::int64_t>::min();
};

struct AxleSpeed {
  double v_x = 0.0;    ///< [m/s], forward positive
  double sigma = 0.0;  ///< [m/s]
};

/// v_x at the rear axle (and at the centre of gravity) from the first live wheels in the table of
/// signals.cpp; empty without a wheel sample. While the held direction is
/// -1, positive (unsigned) speeds count as negative.
[[nodiscard]] std::optional<AxleSpeed> rear_axle_speed(const Vehicle& car, const HeldSignals& held,
                                                       double car_yaw_rate) noexcept;

class GyroBias {
 public:
  explicit GyroBias(const Tuning& tuning) noexcept
      : walk_(squared(tuning.gyro_bias_walk)), variance_(squared(tuning.gyro_bias)) {}

  /// Adds a reading. The car is at rest if no wheel turns and the reading is within 4 σ of the
  /// bias, σ from noise and bias.
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

  double walk_;  ///< growth of the variance per second
  double value_ = 0.0;
  double variance_;
  Block block_, before_;  ///< the block being filled, and the last complete one
  int complete_ = 0;      ///< complete blocks since the car came to rest
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
  if (complete_++ < 2) {
    return;  // a block is used only between two complete ones
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
