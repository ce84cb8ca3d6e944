// What one source has said lately: a short mean of its samples, how fast that changes, and whether
// it repeats itself to the bit.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "estimator/common/time.hpp"

namespace odomd::estimator::integrity {

/// A source is averaged twice: over a short time, by which a fault is seen soon, and over a longer
/// one, by which a small one is seen at all.
enum class Over : std::uint8_t { short_time, long_time };
inline constexpr std::array<double, 2> mean_s{0.06, 0.6};
[[nodiscard]] constexpr double seconds_of(Over over) noexcept {
  return mean_s[static_cast<std::size_t>(over)];
}

/// A mean that forgets, and the mean of it.
struct Mean {
  double value = 0.0;
  double slow = 0.0;
};

struct Witness {
  bool seen = false;
  std::int64_t time_ns = 0;   ///< of the newest sample
  std::int64_t heard_ns = 0;  ///< when it came in
  std::int64_t since_ns = 0;  ///< of the first since it was last silent
  double value = 0.0;
  double before = 0.0;  ///< the sample before the newest
  std::array<Mean, 2> means{};
  double cycle_s = 0.0;  ///< mean time between two samples; 0: not known
  double sigma = 0.0;    ///< of the newest sample
  int same = 0;          ///< samples with the bits of the newest, it included
  std::int64_t same_since_ns = 0;

  std::int64_t jumped_ns = 0;  ///< last time that it changed as no car does; 0: never

  [[nodiscard]] double mean(Over over = Over::short_time) const noexcept {
    return means[static_cast<std::size_t>(over)].value;
  }
  /// Of the mean, per second.
  [[nodiscard]] double rate(Over over) const noexcept {
    const Mean& mean = means[static_cast<std::size_t>(over)];
    // So far behind is a mean of steps: Δt e / (1 - e), e = exp(-Δt / T).
    const double kept = std::exp(-std::max(cycle_s, 1e-4) / seconds_of(over));
    return (mean.value - mean.slow) * (1.0 - kept) / (std::max(cycle_s, 1e-4) * kept);
  }
  /// For so long without a break.
  [[nodiscard]] double heard_s() const noexcept { return seconds_between(since_ns, time_ns); }
  /// What is left of the noise of one sample.
  [[nodiscard]] double noise(Over over) const noexcept {
    return sigma * std::sqrt(cycle_s / (std::min(2.0 * seconds_of(over), heard_s()) + cycle_s));
  }

  /// Whether it was heard so lately that its mean is that of now.
  [[nodiscard]] bool alive(std::int64_t now_ns) const noexcept {
    return seen && cycle_s > 0.0 && seconds_between(heard_ns, now_ns) <= 3.5 * cycle_s + 0.01;
  }

  /// Whether so many samples over so long have had the same bits that no sensor of a car on the
  /// move would have them.
  [[nodiscard]] bool repeats() const noexcept {
    return same >= 4 && seconds_between(same_since_ns, time_ns) >= 0.15;
  }
};

/// Whether a single sample that is wrong is left out. Of rates none may be: what one has too much,
/// the next has too little.
enum class Single : std::uint8_t { left_out, counts };

/// A sample newer than the last one, as it comes in; `change` is the most that a car's motion makes
/// of it.
inline void hear(Witness& witness, std::int64_t time_ns, double value, double sigma, bool same,
                 double change, Single single = Single::left_out) noexcept {
  constexpr double longest_cycle_s = 0.3;
  const double elapsed_s = witness.seen ? seconds_between(witness.time_ns, time_ns) : 0.0;
  if (!witness.seen || elapsed_s > 1.0) {
    witness.means.fill({value, value});
    witness.value = witness.before = value;
    witness.since_ns = time_ns;
  } else {
    // Of three in a row the middle one: a single sample that is wrong counts for nothing.
    // One that is heard more seldom than it is averaged must be taken at its word.
    const double middle = single == Single::counts || witness.cycle_s > mean_s.front()
                              ? value
                              : std::max(std::min(value, witness.value),
                                         std::min(std::max(value, witness.value), witness.before));
    const double cycle_s = std::min(elapsed_s, longest_cycle_s);
    witness.cycle_s += (witness.cycle_s > 0.0 ? 0.1 : 1.0) * (cycle_s - witness.cycle_s);
    for (std::size_t i = 0; i < mean_s.size(); ++i) {
      // Of all that were heard, as long as that is not long.
      const double share =
          std::max(-std::expm1(-cycle_s / mean_s[i]),
                   elapsed_s / (seconds_between(witness.since_ns, time_ns) + elapsed_s));
      Mean& mean = witness.means[i];
      mean.value += share * (middle - mean.value);
      mean.slow += share * (mean.value - mean.slow);
    }
  }
  if (witness.seen && std::abs(value - witness.value) > change) {
    witness.jumped_ns = time_ns;
  }
  if (!witness.seen || !same) {
    witness.same = 0;
    witness.same_since_ns = time_ns;
  }
  witness.same += 1;
  witness.seen = true;
  witness.time_ns = witness.heard_ns = time_ns;
  witness.before = witness.value;
  witness.value = value;
  witness.sigma = sigma;
}

/// What it said before its short mean counts no longer.
inline void begin_anew(Witness& witness) noexcept {
  const Mean lately = witness.means.front();
  witness.means.fill(lately);
  witness.since_ns = witness.time_ns;
}

}  // namespace odomd::estimator::integrity
