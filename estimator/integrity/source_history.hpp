// The recent samples of one source: their means, the rate of change, and repeats.
//
// docs/model.md, "Integrity".
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "estimator/common/time.hpp"

namespace odomd::estimator::integrity {

/// Each source has two means: the short one detects a fault early, the long one detects small
/// faults.
enum class Over : std::uint8_t { short_time, long_time };
inline constexpr std::array<double, 2> mean_s{0.06, 0.6};
[[nodiscard]] constexpr double seconds_of(Over over) noexcept {
  return mean_s[static_cast<std::size_t>(over)];
}

/// A source counts once it has this many samples.
inline constexpr std::size_t least_samples = 5;

/// Silence after which a source with this cycle counts as paused [s].
[[nodiscard]] constexpr double patience_s(double cycle_s) noexcept {
  return 3.5 * cycle_s + 0.01;
}

/// Exponential moving average, and the moving average of that, with the same time constant.
struct Mean {
  double value = 0.0;
  double slow = 0.0;
};

struct SourceHistory {
  std::array<double, least_samples> first{};  ///< samples after the last gap, sorted
  std::size_t begun = 0;                      ///< number of these; 0: no sample yet
  std::int64_t time_ns = 0;                   ///< of the newest sample
  std::int64_t arrival_ns = 0;                ///< of the newest sample
  std::int64_t since_ns = 0;                  ///< first sample after the last gap
  double value = 0.0;
  double previous = 0.0;
  std::array<Mean, 2> means{};
  double cycle_s = 0.0;  ///< mean time between two samples; 0: unknown
  double sigma = 0.0;    ///< of the newest sample
  double largest = 0.0;  ///< largest magnitude of all samples
  int same = 0;          ///< consecutive samples with identical bits
  std::int64_t same_since_ns = 0;
  double step = 0.0;         ///< smallest change of its value; 0: unknown
  double quiet_share = 1.0;  ///< share of samples without noise in ten seconds or so; 1: unknown
  double slip = 0.0;         ///< sum of a wheel's speed changes that no car can make [m/s]
  double new_slip = 0.0;     ///< part of `slip` in the long mean's time, seen by a camera [m/s]

  [[nodiscard]] bool seen() const noexcept { return begun > 0; }
  [[nodiscard]] double mean(Over over = Over::short_time) const noexcept {
    return means[static_cast<std::size_t>(over)].value;
  }
  /// Rate of change of the mean [1/s].
  [[nodiscard]] double rate(Over over) const noexcept {
    const Mean& mean = means[static_cast<std::size_t>(over)];
    // On a ramp the discrete average lags by Δt e / (1 - e), e = exp(-Δt / T).
    const double dt = std::max(cycle_s, 1e-4);
    const double kept = std::exp(-dt / seconds_of(over));
    return (mean.value - mean.slow) * (1.0 - kept) / (dt * kept);
  }
  /// Time since the last gap [s].
  [[nodiscard]] double duration_s() const noexcept { return seconds_between(since_ns, time_ns); }
  /// Standard deviation of the mean.
  [[nodiscard]] double noise(Over over) const noexcept {
    return sigma * std::sqrt(cycle_s / (std::min(2.0 * seconds_of(over), duration_s()) + cycle_s));
  }

  /// Whether there are enough samples, the last of them recent enough for the mean to hold now.
  [[nodiscard]] bool alive(std::int64_t now_ns) const noexcept {
    return begun >= least_samples && cycle_s > 0.0 &&
           seconds_between(arrival_ns, now_ns) <= patience_s(cycle_s);
  }

  /// Whether the bits have been identical for longer than a sensor of a moving car can repeat them.
  [[nodiscard]] bool repeats() const noexcept {
    return same >= 4 && seconds_between(same_since_ns, time_ns) >= 0.15;
  }
  /// Whether the bits repeat more often than noise would. n repeats have the probability pⁿ with
  /// p = quiet_share; the limit, e⁻²² = 3e-10, is one in 10⁴ hours at 100 samples per second.
  [[nodiscard]] bool is_stuck() const noexcept {
    constexpr double least_share = 0.1;
    return repeats() && -(same - 1) * std::log(std::max(quiet_share, least_share)) > 22.0;
  }
};

/// `median`: of three samples, which rejects a single outlier. `none`: for rates, whose errors
/// cancel only if all samples count.
enum class Prefilter : std::uint8_t { median, none };

/// Adds a sample that is newer than the last one.
inline void add_sample(SourceHistory& history, std::int64_t time_ns, double value, double sigma,
                       bool same, Prefilter prefilter = Prefilter::median) noexcept {
  constexpr double longest_cycle_s = 0.3;
  constexpr double gap_s = 1.0;
  const bool first = !history.seen();
  const double elapsed_s = seconds_between(history.time_ns, time_ns);
  if (first || elapsed_s > gap_s) {
    history.begun = 0;
    history.since_ns = time_ns;
  } else {
    // A source slower than the short mean gets no median, which would be too late.
    const auto [low, high] = std::minmax(value, history.value);
    const double middle = prefilter == Prefilter::none || history.cycle_s > mean_s.front()
                              ? value
                              : std::clamp(history.previous, low, high);
    const double cycle_s = std::min(elapsed_s, longest_cycle_s);
    history.cycle_s += (history.cycle_s > 0.0 ? 0.1 : 1.0) * (cycle_s - history.cycle_s);
    for (std::size_t i = 0; i < mean_s.size(); ++i) {
      // Arithmetic mean of all samples until the averaging time has passed.
      const double share =
          std::max(-std::expm1(-cycle_s / mean_s[i]),
                   elapsed_s / (seconds_between(history.since_ns, time_ns) + elapsed_s));
      Mean& mean = history.means[i];
      mean.value += share * (middle - mean.value);
      mean.slow += share * (mean.value - mean.slow);
    }
  }
  // Start from the median of the first samples, so that none of them decides.
  if (history.begun < history.first.size()) {
    const auto begin = history.first.begin();
    const auto end = begin + static_cast<std::ptrdiff_t>(++history.begun);
    *(end - 1) = value;
    std::rotate(std::upper_bound(begin, end - 1, value), end - 1, end);
    const double median = history.first[history.begun / 2];
    history.means.fill({median, median});
  }
  constexpr double share_s = 10.0;
  const double change = std::abs(value - history.value);
  if (!first && change > 0.0) {
    history.step = history.step > 0.0 ? std::min(history.step, change) : change;
  }
  // Rounding alone makes a second difference of up to two steps.
  const double second = std::abs(value - 2.0 * history.value + history.previous);
  const bool quiet = same || std::round(second / history.step) <= 2.0;
  history.quiet_share +=
      std::min(history.cycle_s / share_s, 1.0) * ((quiet ? 1.0 : 0.0) - history.quiet_share);
  if (first || !same) {
    history.same = 0;
    history.same_since_ns = time_ns;
  }
  history.same += 1;
  history.time_ns = history.arrival_ns = time_ns;
  history.previous = history.value;
  history.value = value;
  history.sigma = sigma;
  history.largest = std::max(history.largest, std::abs(value));
}

/// Restarts the long mean from the short one.
inline void restart_means(SourceHistory& history) noexcept {
  const Mean recent = history.means.front();
  history.means.fill(recent);
  history.since_ns = history.time_ns;
}

}  // namespace odomd::estimator::integrity
