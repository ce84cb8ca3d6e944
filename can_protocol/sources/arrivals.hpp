// Follows the clock that stamps the lines of a live pipe: its steps, and the delays of the lines.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <utility>

#include "can_protocol/sources/log_clock.hpp"

namespace odomd::can {

/// Detects a step of the clock behind the stamps of a live pipe.
///
/// `candump -L can0 | odomd --can -` stamps with the wall clock. When this clock steps by an hour,
/// odomd must not wait for an hour, nor treat an hour's frames as late. A log that is piped in must
/// keep its pauses, though. A live pipe is usually empty when it is read; a pipe with a log never
/// is. Pure logic on given times. For use by one thread.
class LiveStamps {
 public:
  /// A smaller jump is not a step of the clock, but a pause, a delay, or frames out of order.
  static constexpr std::int64_t step_ns = 1'000'000'000;

  enum class Input : std::uint8_t { ready, waited_for };
  /// Records whether a read of the input had to wait.
  void read(Input input) noexcept {
    waits_ = static_cast<std::uint8_t>(waits_ * 2U + (input == Input::waited_for ? 1U : 0U));
  }

  /// Adds the next stamp, which was read at `now_ns` (CLOCK_MONOTONIC), and returns the step of the
  /// stamps' clock; empty when there was none.
  [[nodiscard]] std::optional<std::int64_t> step(std::int64_t stamp_ns,
                                                 std::int64_t now_ns) noexcept {
    const std::int64_t stamps = stamp_ns - last_stamp_ns_;
    const std::int64_t ahead = stamps - (now_ns - last_now_ns_);
    const bool first = last_stamp_ns_ == 0;
    last_stamp_ns_ = stamp_ns;
    last_now_ns_ = now_ns;
    // Lateness alone is no step: frames that a process held back are late, but their stamps rise.
    const bool set = ahead > step_ns || stamps < -step_ns;
    return live() && !first && set ? std::optional(ahead) : std::nullopt;
  }

 private:
  [[nodiscard]] bool live() const noexcept { return std::popcount(waits_) >= 4; }

  std::uint8_t waits_ = 0;  // the newest read is the lowest bit
  std::int64_t last_stamp_ns_ = 0;
  std::int64_t last_now_ns_ = 0;
};

/// The smallest delay of the lines of a live pipe: the delay of a line that nothing held up.
///
/// A line cannot arrive before it was stamped, so
///     arrival - stamp = offset of the clocks + l,   l >= 0,
/// and the smallest difference is the best guess at the offset. Not every producer is live, though:
/// lines of a log that is written faster than real time arrive earlier and earlier relative to
/// their stamps. With a live producer the smallest differences of two windows agree. Lines that
/// come later than expected prove less, as any line may be held up: they need longer windows with
/// more lines. There the smallest delay must not fall: it falls after a pause, and rises with a
/// slow clock.
///
/// Pure logic on given times. For use by one thread.
class SmallestDelay {
 public:
  /// Two windows agree when they differ by at most this.
  static constexpr std::int64_t agreement_ns = 5'000'000;

  enum class Trend : std::uint8_t {
    steady,      ///< two short windows agree; for lines that come earlier
    not_falling  ///< the second of two long windows is not lower; for lines that all come later
  };
  explicit SmallestDelay(Trend trend = Trend::steady) noexcept : trend_(trend) {}

  /// Adds a line that arrived at `now_ns`, while the reader was waiting. At the end of a window, if
  /// its change since the previous window fits the trend, returns the smallest arrival - stamp of
  /// both windows; otherwise empty.
  [[nodiscard]] std::optional<std::int64_t> take(std::int64_t stamp_ns,
                                                 std::int64_t now_ns) noexcept {
    if (smallest_ns_ == none) start_ns_ = now_ns;
    smallest_ns_ = std::min(smallest_ns_, now_ns - stamp_ns);
    ++lines_;
    const bool steady = trend_ == Trend::steady;
    if (now_ns - start_ns_ < (steady ? 200'000'000 : 400'000'000) || lines_ < (steady ? 1 : 20))
      return std::nullopt;
    lines_ = 0;
    const std::int64_t before_ns = std::exchange(before_ns_, smallest_ns_);
    smallest_ns_ = none;
    if (before_ns == none) return std::nullopt;
    const std::int64_t rise_ns = before_ns_ - before_ns;
    if (rise_ns < -agreement_ns || (steady && rise_ns > agreement_ns)) return std::nullopt;
    return std::min(before_ns_, before_ns);
  }

  /// Call when the stamps follow another clock from here on.
  void restart() noexcept { *this = SmallestDelay(trend_); }

 private:
  static constexpr std::int64_t none = INT64_MAX;

  Trend trend_;
  int lines_ = 0;  // of the current window
  std::int64_t start_ns_ = 0;
  std::int64_t smallest_ns_ = none;  // of the current window
  std::int64_t before_ns_ = none;    // of the previous window
};

/// Makes the log clock follow the arrivals of a live pipe: its lines come earlier than expected if
/// the first was late or the sender's clock is fast or was stepped ahead, and later if that clock
/// is slow or was stepped back. Pure logic on given times. For use by one thread.
class Arrivals {
 public:
  /// Lines are released `lead_ns` after their arrival; each step of the clock is less than
  /// `most_ns`. `clock` must outlive this.
  Arrivals(LogClock& clock, std::int64_t lead_ns, std::int64_t most_ns) noexcept
      : clock_(clock), lead_ns_(lead_ns), most_ns_(most_ns) {}

  /// Adds a line that arrived at `now_ns`, while the reader was waiting. Returns the advance of the
  /// clock: positive if lines come earlier than expected, negative if later, 0 if it is unchanged.
  std::int64_t take(std::int64_t stamp_ns, std::int64_t now_ns) noexcept {
    const auto earlier = earlier_.take(stamp_ns, now_ns);
    const auto later = later_.take(stamp_ns, now_ns);
    const auto release_ns = [&](std::int64_t delay_ns) { return stamp_ns + delay_ns + lead_ns_; };
    if (earlier)
      if (const std::int64_t by_ns =
              clock_.advance(stamp_ns, release_ns(*earlier), most_ns_, now_ns);
          by_ns != 0)
        return by_ns;
    return later ? -clock_.set_back(stamp_ns, release_ns(*later), most_ns_, now_ns) : 0;
  }

  /// Call when the stamps follow another clock from here on.
  void restart() noexcept {
    earlier_.restart();
    later_.restart();
  }

 private:
  LogClock& clock_;
  std::int64_t lead_ns_;
  std::int64_t most_ns_;
  SmallestDelay earlier_{SmallestDelay::Trend::steady};
  SmallestDelay later_{SmallestDelay::Trend::not_falling};
};

}  // namespace odomd::can
