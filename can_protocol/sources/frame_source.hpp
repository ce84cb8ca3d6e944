// Where frames come from: the small interface that the beat drains.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/counter.hpp"
#include "can_protocol/frame.hpp"

namespace odomd::can {

/// Frames that one drain takes from one bus at the most; the rest carries over to the next tick.
inline constexpr std::size_t max_frames_per_drain = 256;

enum class LinkState : std::uint8_t { up, down, gone, ended };

/// What a source has seen since it was opened. Written by whoever drains (or by the feeder thread),
/// read by housekeeping.
struct SourceCounters {
  Counter received;         ///< data and remote frames handed on
  Counter lost;             ///< dropped by the kernel's receive queue (SO_RXQ_OVFL)
  Counter error_frames;     ///< error frames seen
  Counter carried_over;     ///< drains that left frames behind for the next tick
  Counter link_downs;       ///< times the link went down or the interface vanished
  Counter stamp_fallbacks;  ///< frames without a usable kernel stamp, timed by their drain
  Counter malformed;        ///< lines of a log, or frames, that could not be taken

  Counter hardware_fallbacks;    ///< hardware stamps were asked for, the frame bore a software one
  Counter clock_steps;           ///< the wall clock, in which the kernel stamps, was set
  Counter suspends;              ///< the machine slept
  Counter bus_offs;              ///< error frames that say bus-off
  Counter controller_overflows;  ///< error frames that say the controller lost frames
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Moves frames that have arrived into `frames`, in their order, and says how many. Real-time
  /// safe: never blocks, allocates, locks or throws; bounded by frames.size().
  ///
  /// `now_ns` is CLOCK_MONOTONIC of the drain. Frame times are CLOCK_MONOTONIC. A live bus hands
  /// out what is in the socket; a paced log what its feeder has released and is stamped <=
  /// `tick_ns`, the time the tick is valid at.
  virtual std::size_t drain(std::span<Frame> frames, std::int64_t tick_ns,
                            std::int64_t now_ns) noexcept = 0;

  /// State of the link below, as last seen; safe from any thread.
  [[nodiscard]] virtual LinkState link() const noexcept = 0;
  [[nodiscard]] virtual const SourceCounters& counters() const noexcept = 0;

  /// Housekeeping, a few times a second, from one thread that is not the beat: re-opens what went
  /// away. May allocate and call the system; never throws.
  virtual void maintain() noexcept {}

  /// What is worth telling the user since the source was opened, one line each, in the order in
  /// which it came; of each kind the first. It only grows. From the thread that calls `maintain`.
  [[nodiscard]] virtual std::vector<std::string> complaints() const { return {}; }

  /// What the user called it: "can0", "drive.log", "-".
  [[nodiscard]] virtual const std::string& name() const noexcept = 0;
};

}  // namespace odomd::can
