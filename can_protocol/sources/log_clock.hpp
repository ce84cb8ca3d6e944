// The clock of the logs that a live daemon plays: maps their stamps to CLOCK_MONOTONIC.
//
// Offline, tick k is valid at a multiple of the period on the log's clock and takes the frames
// stamped up to then. Live, the ticks lie at first_tick + k * period on CLOCK_MONOTONIC. Both runs
// use the same frames in the same ticks if the two grids coincide, so the offset makes them
// coincide. This releases the first frame up to one period later than possible.
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
  // Find: release - first_tick = stamp (mod period), with release >= earliest.
  const std::int64_t phase = (stamp_ns % period_ns) + (first_tick_ns % period_ns);
  const std::int64_t rest = (phase - earliest_ns % period_ns) % period_ns;
  return earliest_ns + (rest < 0 ? rest + period_ns : rest);
}

/// Shared by the feeders of all logs that one daemon plays. The first frame of any log sets the
/// clock permanently, except for a live pipe, whose clock may be stepped or drift, or whose first
/// line may have arrived late. Any thread, lock-free.
///
/// A frame is released at stamp - base - advance; the clock's offset is base + advance. A feeder
/// subtracts the base when it reads a frame, and the drain subtracts the advance when it returns
/// the frame, so an advance also applies to the frames in between.
class LogClock {
 public:
  LogClock(std::int64_t first_tick_ns, std::int64_t period_ns) noexcept
      : first_tick_ns_(first_tick_ns), period_ns_(period_ns) {}

  [[nodiscard]] std::int64_t period_ns() const noexcept { return period_ns_; }

  /// Log clock - CLOCK_MONOTONIC; empty before the first frame.
  [[nodiscard]] std::optional<std::int64_t> offset_ns() const noexcept {
    const std::int64_t base = base_ns_.load(std::memory_order_acquire);
    return base == unset ? std::nullopt : std::optional(base + advance_ns());
  }

  /// The sum of all advances.
  [[nodiscard]] std::int64_t advance_ns() const noexcept {
    return advance_ns_.load(std::memory_order_acquire);
  }

  /// Maps `stamp_ns` to an instant not before `earliest_ns`, unless the clock is running already;
  /// returns the current base.
  std::int64_t start(std::int64_t stamp_ns, std::int64_t earliest_ns) noexcept {
    const std::int64_t base = base_for(stamp_ns, earliest_ns);
    std::int64_t current = unset;
    if (base_ns_.compare_exchange_strong(current, base, std::memory_order_acq_rel)) return base;
    return current;
  }

  /// Like start(), but also if the clock is running: the stamps follow another clock from here on.
  std::int64_t restart(std::int64_t stamp_ns, std::int64_t earliest_ns) noexcept {
    const std::int64_t base = base_for(stamp_ns, earliest_ns);
    base_ns_.store(base, std::memory_order_release);
    return base;
  }

  /// Advances the clock if this releases `stamp_ns` earlier by two periods or more, but by less
  /// than `most_ns`: the line that started the clock was late. Returns the advance [ns], a multiple
  /// of the period; 0: unchanged.
  std::int64_t advance(std::int64_t stamp_ns, std::int64_t earliest_ns, std::int64_t most_ns,
                       std::int64_t now_ns) noexcept {
    const std::int64_t by = advance_for(stamp_ns, earliest_ns);
    if (by > -2 * period_ns_) in_time_ns_.store(now_ns, std::memory_order_release);
    return by >= 2 * period_ns_ && by < most_ns ? advance_by(by) : 0;
  }

  /// The opposite of advance(), for a feeder whose lines are all late: sets the clock back and
  /// returns by how much. The clock stays unchanged while the lines of another feeder are in time.
  std::int64_t set_back(std::int64_t stamp_ns, std::int64_t earliest_ns, std::int64_t most_ns,
                        std::int64_t now_ns) noexcept {
    constexpr std::int64_t recent_ns = 600'000'000;
    const std::int64_t by = -advance_for(stamp_ns, earliest_ns);
    const bool kept = now_ns - in_time_ns_.load(std::memory_order_acquire) < recent_ns;
    return by < 2 * period_ns_ || by >= most_ns || kept ? 0 : -advance_by(-by);
  }

 private:
  static constexpr std::int64_t unset = INT64_MIN;

  [[nodiscard]] std::int64_t base_for(std::int64_t stamp_ns,
                                      std::int64_t earliest_ns) const noexcept {
    return stamp_ns - aligned_release(stamp_ns, earliest_ns, first_tick_ns_, period_ns_) -
           advance_ns();
  }

  /// The advance with which `stamp_ns` is released as early as allowed; 0 before the first frame.
  [[nodiscard]] std::int64_t advance_for(std::int64_t stamp_ns,
                                         std::int64_t earliest_ns) const noexcept {
    const std::int64_t base = base_ns_.load(std::memory_order_acquire);
    return base == unset ? 0 : base_for(stamp_ns, earliest_ns) - base;
  }

  std::int64_t advance_by(std::int64_t by_ns) noexcept {
    std::int64_t before = advance_ns();
    const bool done =
        advance_ns_.compare_exchange_strong(before, before + by_ns, std::memory_order_acq_rel);
    return done ? by_ns : 0;
  }

  std::int64_t first_tick_ns_;
  std::int64_t period_ns_;
  std::atomic<std::int64_t> in_time_ns_{INT64_MIN / 2};
  std::atomic<std::int64_t> base_ns_{unset};
  std::atomic<std::int64_t> advance_ns_{0};
};

}  // namespace odomd::can
