// The clock of the logs that a live daemon plays: where their stamps lie on CLOCK_MONOTONIC.
//
// Offline, tick k is valid at a multiple of the period on the log's clock and takes in the stamps
// up to it. Live, the ticks lie at first_tick + k * period on CLOCK_MONOTONIC. Both runs take the
// same frames into the same ticks if the two grids coincide, so the offset is chosen among those
// that make them coincide: the first frame is released up to one period later than it could be.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

namespace odomd::can {

/// The earliest instant on CLOCK_MONOTONIC, not before `earliest_ns`, at which a frame stamped
/// `stamp_ns` may be released so that multiples of the period on the log's clock fall on ticks.
[[nodiscard]] constexpr std::int64_t aligned_release(std::int64_t stamp_ns,
                                                     std::int64_t earliest_ns,
                                                     std::int64_t first_tick_ns,
                                                     std::int64_t period_ns) noexcept {
  // Wanted: release - first_tick = stamp (mod period), with release >= earliest.
  const std::int64_t phase = (stamp_ns % period_ns) + (first_tick_ns % period_ns);
  const std::int64_t rest = (phase - earliest_ns % period_ns) % period_ns;
  return earliest_ns + (rest < 0 ? rest + period_ns : rest);
}

/// Shared by the feeders of all logs that one daemon plays: the first frame of any of them sets it,
/// for good but for a live pipe whose clock is set. Any thread, lock-free.
class LogClock {
 public:
  LogClock(std::int64_t first_tick_ns, std::int64_t period_ns) noexcept
      : first_tick_ns_(first_tick_ns), period_ns_(period_ns) {}

  [[nodiscard]] std::int64_t period_ns() const noexcept { return period_ns_; }

  /// Log clock - CLOCK_MONOTONIC; nothing before the first frame.
  [[nodiscard]] std::optional<std::int64_t> offset_ns() const noexcept {
    const std::int64_t offset = offset_ns_.load(std::memory_order_acquire);
    return offset == unset ? std::nullopt : std::optional(offset);
  }

  /// Maps `stamp_ns` to an instant not before `earliest_ns` unless the clock runs already; the
  /// offset in force.
  std::int64_t start(std::int64_t stamp_ns, std::int64_t earliest_ns) noexcept {
    std::int64_t offset =
        stamp_ns - aligned_release(stamp_ns, earliest_ns, first_tick_ns_, period_ns_);
    std::int64_t current = unset;
    if (offset_ns_.compare_exchange_strong(current, offset, std::memory_order_acq_rel))
      return offset;
    return current;
  }

  /// Maps `stamp_ns` so although the clock runs: the stamps follow another clock from here on.
  std::int64_t restart(std::int64_t stamp_ns, std::int64_t earliest_ns) noexcept {
    const std::int64_t offset =
        stamp_ns - aligned_release(stamp_ns, earliest_ns, first_tick_ns_, period_ns_);
    offset_ns_.store(offset, std::memory_order_release);
    return offset;
  }

 private:
  static constexpr std::int64_t unset = INT64_MIN;

  std::int64_t first_tick_ns_;
  std::int64_t period_ns_;
  std::atomic<std::int64_t> offset_ns_{unset};
};

}  // namespace odomd::can
