// The grid of instants at which poses are valid, and the choice of the next one. Pure arithmetic on
// given times, so that tests can make up times.
#pragma once

#include <cstdint>

namespace odomd::daemon {

/// Tick k is valid at T_k = T_0 + k * period.
struct TickGrid {
  std::int64_t first_ns = 0;  ///< T_0, a multiple of the period
  std::int64_t period_ns = 5'000'000;

  [[nodiscard]] constexpr std::int64_t time_of(std::uint64_t tick) const {
    return first_ns + static_cast<std::int64_t>(tick) * period_ns;
  }

  /// The newest tick that is due at `now_ns`.
  [[nodiscard]] constexpr std::uint64_t due_at(std::int64_t now_ns) const {
    return now_ns <= first_ns ? 0 : static_cast<std::uint64_t>((now_ns - first_ns) / period_ns);
  }
};

/// A grid whose tick 1 is the first multiple of the period after `now_ns`. The numbers begin at 1
/// because 0 means "none yet" to clients.
[[nodiscard]] constexpr TickGrid grid_from(std::int64_t now_ns, std::int64_t period_ns) {
  return {now_ns - now_ns % period_ns, period_ns};
}

struct NextTick {
  std::uint64_t tick = 0;
  std::uint64_t missed = 0;  ///< cycles of the grid that were skipped
};

/// The tick to run after waking for `tick` at `now_ns`: `tick`, or the newest tick that is due if
/// `now_ns` is a period or more late.
[[nodiscard]] constexpr NextTick due_tick(const TickGrid& grid, std::uint64_t tick,
                                          std::int64_t now_ns) {
  const std::uint64_t due = grid.due_at(now_ns);
  return due > tick ? NextTick{due, due - tick} : NextTick{tick, 0};
}

/// The tick to run after finishing `tick` at `now_ns`: one in the future. After an overrun the
/// cycles that became due are skipped: the phase is kept, and a beat that cannot keep up still
/// sleeps, so the real-time thread never starves the machine.
[[nodiscard]] constexpr NextTick next_tick(const TickGrid& grid, std::uint64_t tick,
                                           std::int64_t now_ns) {
  const std::uint64_t due = grid.due_at(now_ns);
  return due > tick ? NextTick{due + 1, due - tick} : NextTick{tick + 1, 0};
}

}  // namespace odomd::daemon
