// What the models without a window know of the sensors: the newest value of each signal, held until
// a newer one comes, and v_x from whatever wheel speeds there are.
//
// Newest is by the samples' own times, so the order of arrival within a tick does not matter.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "estimator/common/measurement.hpp"
#include "estimator/common/settings.hpp"

namespace odomd::estimator {

/// The newest sample of a source; before the first, 0 and the sigma of the source.
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

  /// Takes a sample in, or says why not: non_finite, future (ahead of `latest_ns`), gated (beyond
  /// any car's physics), duplicate, too_old (older than the one held). Not for the camera's.
  Verdict take(const Measurement& sample, std::int64_t latest_ns) noexcept;

  [[nodiscard]] const HeldSignal& operator[](Source source) const noexcept {
    return held_[index_of(source)];
  }
  /// Heard at least once, and within half a second of the newest sample of a wheel.
  [[nodiscard]] bool alive(Source wheel) const noexcept;

 private:
  std::array<HeldSignal, source_count> held_{};
  std::array<double, source_count> sigma_{};
  std::int64_t newest_wheel_ns_ = std::numeric_limits<std::int64_t>::min();
};

struct AxleSpeed {
  double v_x = 0.0;    ///< [m/s], forward positive
  double sigma = 0.0;  ///< [m/s]
};

/// v_x, which a rigid car has at the rear axle as at the centre of gravity, by the first choice of
/// wheels that are alive (the table in signals.cpp); nothing where no wheel was ever heard. While
/// the held direction is -1, positive speeds count as negative: those of sensors that do not know a
/// sign.
[[nodiscard]] std::optional<AxleSpeed> rear_axle_speed(const Vehicle& car, const HeldSignals& held,
                                                       double car_yaw_rate) noexcept;

}  // namespace odomd::estimator
