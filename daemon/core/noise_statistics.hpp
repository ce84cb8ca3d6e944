// The noise that the filter estimates for a source, passed from the beat to the status.
#pragma once

#include <bit>
#include <cstdint>

#include "base/counter.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// One thread writes, any may read; the numbers are recent, but may be of different ticks.
class NoiseStatistics {
 public:
  void set(const estimator::SourceNoise& noise) noexcept {
    stated_.set(bits(noise.stated));
    at_rest_.set(bits(noise.at_rest));
    moving_.set(bits(noise.moving));
    speed_share_.set(bits(noise.speed_share));
  }

  [[nodiscard]] estimator::SourceNoise get() const noexcept {
    return {.stated = real(stated_),
            .at_rest = real(at_rest_),
            .moving = real(moving_),
            .speed_share = real(speed_share_)};
  }

 private:
  static std::uint64_t bits(double value) noexcept { return std::bit_cast<std::uint64_t>(value); }
  static double real(const Counter& bits) noexcept { return std::bit_cast<double>(bits.get()); }

  // Bit patterns of doubles
  Counter stated_;
  Counter at_rest_;
  Counter moving_;
  Counter speed_share_;
};

}  // namespace odomd::daemon
