// Random numbers that are the same on all machines: a counter-based generator with a stream for
// each user, so that switching one sensor off does not change the draws of the others.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

namespace odomd::sim {

/// One stream, from the seed of the run and the name of its user. Streams are independent.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name) : key_(mix(seed)) {
    for (const char letter : name) key_ = mix(key_ ^ static_cast<unsigned char>(letter));
  }

  std::uint64_t bits() { return mix(key_ + golden_ratio * ++count_); }

  /// In [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11U) * 0x1p-53; }

  /// In [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Mean 0, standard deviation 1 (Box and Muller, 1958). Always uses two draws.
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log1p(-uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

  /// Mean 1.
  double exponential() { return -std::log1p(-uniform()); }

 private:
  static constexpr std::uint64_t golden_ratio = 0x9E37'79B9'7F4A'7C15ULL;

  /// The finaliser of SplitMix64 (Steele, Lea, Flood, 2014): each input bit affects all output
  /// bits.
  static constexpr std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xBF58'476D'1CE4'E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D0'49BB'1331'11EBULL;
    return z ^ (z >> 31U);
  }

  std::uint64_t key_;
  std::uint64_t count_ = 0;
};

}  // namespace odomd::sim
