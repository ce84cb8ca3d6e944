// Saturating arithmetic of times: a received time stamp may be at either end of the range.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

namespace odomd::estimator {

inline constexpr double seconds_per_ns = 1e-9;
inline constexpr double ns_per_second = 1e9;

/// later - earlier, saturated.
[[nodiscard]] inline std::int64_t ns_between(std::int64_t earlier, std::int64_t later) noexcept {
  std::int64_t difference = 0;
  if (__builtin_sub_overflow(later, earlier, &difference)) {
    return later < earlier ? std::numeric_limits<std::int64_t>::min()
                           : std::numeric_limits<std::int64_t>::max();
  }
  return difference;
}

[[nodiscard]] inline double seconds_between(std::int64_t earlier, std::int64_t later) noexcept {
  return static_cast<double>(ns_between(earlier, later)) * seconds_per_ns;
}

/// time + ns, saturated.
[[nodiscard]] inline std::int64_t ns_after(std::int64_t time, std::int64_t ns) noexcept {
  std::int64_t later = 0;
  if (__builtin_add_overflow(time, ns, &later)) {
    return ns < 0 ? std::numeric_limits<std::int64_t>::min()
                  : std::numeric_limits<std::int64_t>::max();
  }
  return later;
}

/// Arrival time of a sample; if it is not stated (0), the time of the next tick.
[[nodiscard]] inline std::int64_t arrival_of(std::int64_t stated_ns,
                                             std::optional<std::int64_t> last_tick_ns,
                                             std::int64_t period_ns) noexcept {
  const std::int64_t next_tick_ns =
      last_tick_ns ? ns_after(*last_tick_ns, period_ns) : std::numeric_limits<std::int64_t>::max();
  return stated_ns != 0 ? stated_ns : next_tick_ns;
}

}  // namespace odomd::estimator
