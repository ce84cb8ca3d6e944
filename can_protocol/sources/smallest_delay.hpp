// The smallest delay of the lines of a live pipe: the delay of a line that nothing held up.
//
// A line cannot arrive before it was stamped, so
//     arrival - stamp = offset of the clocks + l,   l >= 0,
// and the smallest difference is the best guess at the offset. Not every producer is live, though:
// one that writes a log faster than real time arrives earlier and earlier relative to its stamps.
// For a live one the smallest differences of two windows agree.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <utility>

namespace odomd::can {

/// Pure logic on given times. One thread.
class SmallestDelay {
 public:
  static constexpr std::int64_t window_ns = 200'000'000;
  /// Two windows agree when they differ by less.
  static constexpr std::int64_t agreement_ns = 5'000'000;

  /// Takes a line that arrived while the reader was waiting, at `now_ns`. Returns the smallest
  /// arrival - stamp at the end of a window that agrees with the previous one; otherwise empty.
  [[nodiscard]] std::optional<std::int64_t> take(std::int64_t stamp_ns,
                                                 std::int64_t now_ns) noexcept {
    if (smallest_ns_ == none) start_ns_ = now_ns;
    smallest_ns_ = std::min(smallest_ns_, now_ns - stamp_ns);
    if (now_ns - start_ns_ < window_ns) return std::nullopt;
    const std::int64_t before_ns = std::exchange(before_ns_, smallest_ns_);
    smallest_ns_ = none;
    if (before_ns == none || std::abs(before_ns_ - before_ns) > agreement_ns) return std::nullopt;
    return std::min(before_ns_, before_ns);
  }

  /// The stamps follow another clock from here on.
  void restart() noexcept { *this = {}; }

 private:
  static constexpr std::int64_t none = INT64_MAX;

  std::int64_t start_ns_ = 0;
  std::int64_t smallest_ns_ = none;  // of the current window
  std::int64_t before_ns_ = none;    // of the previous one
};

}  // namespace odomd::can
