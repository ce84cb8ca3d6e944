// Detects a step of the clock behind the stamps of a live pipe.
//
// `candump -L can0 | odomd --can -` stamps with the wall clock. When this clock steps by an hour,
// odomd must not wait for an hour, nor treat an hour's frames as late. A log that is piped in must
// keep its pauses, though. A live pipe is usually empty when it is read; a pipe with a log never
// is.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

namespace odomd::can {

/// Pure logic on given times. For use by one thread.
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
    // Being late alone is no step: frames that a process held back are late, but their stamps rise.
    const bool set = ahead > step_ns || stamps < -step_ns;
    return live() && !first && set ? std::optional(ahead) : std::nullopt;
  }

 private:
  [[nodiscard]] bool live() const noexcept { return std::popcount(waits_) >= 4; }

  std::uint8_t waits_ = 0;  // the newest read is the lowest bit
  std::int64_t last_stamp_ns_ = 0;
  std::int64_t last_now_ns_ = 0;
};

}  // namespace odomd::can
