// The signals for models without a window: the newest value of each, held until the next one, and
// v_x from the available wheel speeds. Newest by the samples' own times, whatever the order of
// arrival.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"

namespace odomd::estimator {

/// The newest sample of a source; 0 and the default sigma before the first.
struct HeldSignal {
  bool seen = false;
  std::int64_t time_ns = 0;
  double value = 0.0;
  double sigma = 0.0;  ///< at most the largest value that is not gated
};

class HeldSignals {
 public:
  /// `sigma` as in FilterSettings.
  explicit HeldSignals(const std::array<double, source_count>& sigma) noexcept;

  /// Holds a sample, or returns why not: non_finite, future (after `latest_ns`), gated (beyond
  /// physical_limit), duplicate, too_old (older than the one held). Not for camera poses.
  Verdict take(const Measurement& sample, std::int64_t latest_ns) noexcept;

  [[nodiscard]] const HeldSignal& operator[](Source source) const noexcept {
    return held_[index_of(source)];
  }
  /// Whether there is a sample within half a second of the newest wheel sample.
  [[nodiscard]] bool alive(Source wheel) const noexcept;
  /// Whether none of the wheels that are alive turns: faster than twice its sigma, within 0.01 to
  /// 0.03 m/s. False without a wheel.
  [[nodiscard]] bool wheels_still() const noexcept;

 private:
  std::array<HeldSignal, source_count> held_{};
  std::array<double, source_count> sigma_{};
  std::int64_t newest_wheel_ns_ = std::numeric_limits<std::int64_t>::min();
};

struct AxleSpeed {
  double v_x = 0.0;    ///< [m/s], forward positive
  double sigma = 0.0;  ///< [m/s]
};

/// v_x, equal at the rear axle and the centre of gravity, by the first choice of wheels that are
/// alive (the table in signals.cpp); nothing without a wheel sample. While the held direction is
/// -1, positive (unsigned) speeds count as negative.
[[nodiscard]] std::optional<AxleSpeed> rear_axle_speed(const Vehicle& car, const HeldSignals& held,
                                                       double car_yaw_rate) noexcept;

}  // namespace odomd::estimator
