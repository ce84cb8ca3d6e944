// Converts CLOCK_REALTIME, the kernel's clock for stamping frames, to CLOCK_MONOTONIC.
//
// The kernel keeps REALTIME - MONOTONIC constant between two steps of the wall clock (slewing moves
// both equally; a suspend, which stops MONOTONIC, is a step). So each bracketed reading
//     before <= instant of `realtime` <= after   (on MONOTONIC)
// places the offset in [realtime - after, realtime - before]. The intersection of all readings
// gives the offset to a few nanoseconds; an empty intersection means a step.
//
// A stamp from before a step is converted with the offset of that time. Each offset has a span of
// MONOTONIC in which it may have applied. The newest offset that converts a stamp to a time in the
// offset's span is used.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <optional>

namespace odomd {

/// Reads a system clock [ns]. Real-time safe.
[[nodiscard]] std::int64_t read_clock(clockid_t clock) noexcept;
[[nodiscard]] inline std::int64_t monotonic_now() noexcept {
  return read_clock(CLOCK_MONOTONIC);
}

/// The clocks, read one after the other in this order.
struct ClockReading {
  std::int64_t before_ns = 0;    ///< CLOCK_MONOTONIC
  std::int64_t realtime_ns = 0;  ///< CLOCK_REALTIME
  std::int64_t boottime_ns = 0;  ///< CLOCK_BOOTTIME
  std::int64_t after_ns = 0;     ///< CLOCK_MONOTONIC
};

/// Reads the clocks without a system call where the machine has a vDSO clock source. When a reading
/// was interrupted, reads again, at most twice, and returns the fastest reading. Real-time safe.
[[nodiscard]] ClockReading read_clocks() noexcept;

enum class ClockEvent : std::uint8_t { none, stepped, suspended };

/// Real-time safe. Reads no clock itself. For one thread.
class WallClock {
 public:
  /// No frame waits longer than this until it is drained.
  static constexpr std::int64_t max_age_ns = 10'000'000'000;

  /// What happened since the previous reading: the wall clock was stepped, or the machine was
  /// suspended (which also steps it).
  ClockEvent update(const ClockReading& reading) noexcept {
    const Interval offset{reading.realtime_ns - reading.after_ns - rounding_ns,
                          reading.realtime_ns - reading.before_ns + rounding_ns};
    const Interval boot{reading.boottime_ns - reading.after_ns - rounding_ns,
                        reading.boottime_ns - reading.before_ns + rounding_ns};
    if (count_ == 0) {
      boot_ = boot;
      begin_span(offset, INT64_MIN);
      last_reading_ns_ = reading.after_ns;
      return ClockEvent::none;
    }
    ClockEvent event = ClockEvent::none;
    if (!boot_.narrow(boot)) {
      boot_ = boot;
      event = ClockEvent::suspended;
    }
    if (!spans_[0].offset.narrow(offset)) {
      spans_[0].until_ns = reading.after_ns;
      begin_span(offset, last_reading_ns_);
      if (event == ClockEvent::none) event = ClockEvent::stepped;
    }
    last_reading_ns_ = reading.after_ns;
    return event;
  }

  /// The stamp on CLOCK_MONOTONIC, not after `now_ns`; empty when no offset makes it a plausible
  /// time of reception.
  [[nodiscard]] std::optional<std::int64_t> to_monotonic(std::int64_t realtime_ns,
                                                         std::int64_t now_ns) const noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      const OffsetSpan& span = spans_[i];
      const std::int64_t time = realtime_ns - span.offset.middle();
      const std::int64_t earliest = std::max(span.from_ns, now_ns - max_age_ns);
      const std::int64_t latest = std::min(span.until_ns, now_ns);
      if (time >= earliest - slack_ns && time <= latest + slack_ns) return std::min(time, now_ns);
    }
    return std::nullopt;
  }

  /// CLOCK_REALTIME - CLOCK_MONOTONIC now. Call only after the first update.
  [[nodiscard]] std::int64_t offset_ns() const noexcept { return spans_[0].offset.middle(); }

 private:
  static constexpr std::int64_t rounding_ns = 1;    // each clock is truncated to nanoseconds
  static constexpr std::int64_t slack_ns = 50'000;  // tolerance while readings are few

  struct Interval {
    std::int64_t low = 0;
    std::int64_t high = 0;

    /// Intersects with another; when that would be empty, returns false and changes nothing.
    bool narrow(const Interval& other) noexcept {
      if (other.low > high || other.high < low) return false;
      low = std::max(low, other.low);
      high = std::min(high, other.high);
      return true;
    }
    [[nodiscard]] std::int64_t middle() const noexcept { return low + (high - low) / 2; }
  };

  struct OffsetSpan {
    Interval offset;
    std::int64_t from_ns = 0;
    std::int64_t until_ns = 0;
  };

  void begin_span(const Interval& offset, std::int64_t from_ns) noexcept {
    std::shift_right(spans_.begin(), spans_.end(), 1);
    // INT64_MIN and INT64_MAX as bounds would overflow with the slack.
    spans_[0] = {offset, std::max(from_ns, INT64_MIN / 2), INT64_MAX / 2};
    count_ = std::min(count_ + 1, spans_.size());
  }

  std::array<OffsetSpan, 4> spans_{};  // newest first
  std::size_t count_ = 0;
  Interval boot_;
  std::int64_t last_reading_ns_ = 0;
};

}  // namespace odomd
