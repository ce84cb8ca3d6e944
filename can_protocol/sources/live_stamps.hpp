// Whether the stamps of a pipe that is fed as things happen follow a clock that was set.
//
// `candump -L can0 | odomd --can -` stamps by the wall clock. When that is set by an hour, a pause
// of an hour must not be waited for, nor an hour's frames be taken for late ones. A log that is
// piped in must keep its pauses, though. What tells the two apart: a live pipe is empty most of the
// times that somebody looks; one that a log is poured into never is.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

namespace odomd::can {

/// Pure logic on given times. One thread.
class LiveStamps {
 public:
  /// Less than this is a pause, a delay, or frames out of order.
  static constexpr std::int64_t step_ns = 1'000'000'000;

  enum class Input : std::uint8_t { ready, waited_for };
  /// The input was read, and this is how it was found.
  void read(Input input) noexcept {
    waits_ = static_cast<std::uint8_t>(waits_ * 2U + (input == Input::waited_for ? 1U : 0U));
  }

  /// Takes the next stamp in, at hand since `now_ns` (CLOCK_MONOTONIC), and says by how much the
  /// clock behind it was set; nothing where it was not.
  [[nodiscard]] std::optional<std::int64_t> step(std::int64_t stamp_ns,
                                                 std::int64_t now_ns) noexcept {
    const std::int64_t stamps = stamp_ns - last_stamp_ns_;
    const std::int64_t ahead = stamps - (now_ns - last_now_ns_);
    const bool first = last_stamp_ns_ == 0;
    last_stamp_ns_ = stamp_ns;
    last_now_ns_ = now_ns;
    // Behind their arrival are also frames that a process kept; but their stamps rise.
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
