// The smallest delay of the lines of a live pipe: the delay of a line that nothing held up.
//
// A line cannot arrive before it was stamped, so
//     arrival - stamp = offset of the clocks + l,   l >= 0,
// and the smallest difference is the best guess at the offset. Not every producer is live, though:
// one that writes a log faster than real time arrives earlier and earlier relative to its stamps.
// For a live one the smallest differences of two windows agree. Lines that come later than before
// prove less than earlier ones, as any of them may be held up: this takes more of them, and delays
// that do not fall, as after a pause of the pipe. They may rise: then the stamps' clock is slow.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "can_protocol/sources/log_clock.hpp"

namespace odomd::can {

/// Pure logic on given times. One thread.
class SmallestDelay {
 public:
  /// Two windows agree when they differ by less.
  static constexpr std::int64_t agreement_ns = 5'000'000;

  enum class Trend : std::uint8_t {
    steady,      ///< two short windows agree: how early lines come
    not_falling  ///< nor does the second of two long ones lie below: how late they all come
  };
  explicit SmallestDelay(Trend trend = Trend::steady) noexcept : trend_(trend) {}

  /// Takes a line that arrived while the reader was waiting, at `now_ns`. Returns the smallest
  /// arrival - stamp at the end of a window with this trend since the previous one; otherwise
  /// empty.
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

  /// The stamps follow another clock from here on.
  void restart() noexcept { *this = SmallestDelay(trend_); }

 private:
  static constexpr std::int64_t none = INT64_MAX;

  Trend trend_;
  int lines_ = 0;  // of the current window
  std::int64_t start_ns_ = 0;
  std::int64_t smallest_ns_ = none;  // of the current window
  std::int64_t before_ns_ = none;    // of the previous one
};

/// Keeps the log clock where the lines of a live pipe arrive: they come earlier when the first one
/// was late or their clock is fast or was stepped ahead, and later when it is slow or was stepped
/// back. Pure logic on given times. One thread.
class Arrivals {
 public:
  /// Lines are released `lead_ns` after their arrival, and the clock moves by less than `most_ns`
  /// at once. `clock` must outlive this.
  Arrivals(LogClock& clock, std::int64_t lead_ns, std::int64_t most_ns) noexcept
      : clock_(clock), lead_ns_(lead_ns), most_ns_(most_ns) {}

  /// Takes a line that arrived while the reader was waiting, at `now_ns`. Returns by how much lines
  /// come earlier than the clock expected, which follows them; negative: later.
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

  /// The stamps follow another clock from here on.
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
