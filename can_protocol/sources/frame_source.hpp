// The interface of frame sources, which the beat drains.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/counter.hpp"
#include "can_protocol/frame.hpp"

namespace odomd::can {

/// The maximum number of frames in one drain of one bus; the rest carries over to the next tick.
inline constexpr std::size_t max_frames_per_drain = 256;

enum class LinkState : std::uint8_t { up, down, gone, ended };

/// Counters of a source since it was opened. Written by the draining thread (or the feeder thread),
/// read by housekeeping.
struct SourceCounters {
  Counter received;      ///< data and remote frames delivered
  Counter lost;          ///< dropped by the kernel's receive queue (SO_RXQ_OVFL)
  Counter error_frames;  ///< error frames seen
  Counter carried_over;  ///< drains that left frames for the next tick
  Counter link_downs;    ///< number of times the link went down or the interface disappeared
  Counter
      stamp_fallbacks;  ///< frames without a usable kernel stamp, which got the time of the drain
  Counter malformed;    ///< malformed lines of a log, or malformed frames

  Counter
      hardware_fallbacks;  ///< hardware stamps were requested, but the frame had a software stamp
  Counter clock_steps;     ///< steps of the wall clock, which the kernel uses for stamps
  Counter suspends;        ///< suspends of the machine
  Counter bus_offs;        ///< error frames that report bus-off
  Counter controller_overflows;  ///< error frames that report frames lost in the controller
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Moves frames that have arrived into `frames`, in order, and returns their number. Real-time
  /// safe: never blocks, allocates, locks or throws; bounded by frames.size().
  ///
  /// `now_ns` is CLOCK_MONOTONIC of the drain. Frame times are CLOCK_MONOTONIC. A live bus returns
  /// the frames in the socket; a paced log returns those that its feeder has released with a stamp
  /// <= `tick_ns`, the time at which the tick is valid.
  virtual std::size_t drain(std::span<Frame> frames, std::int64_t tick_ns,
                            std::int64_t now_ns) noexcept = 0;

  /// The latest known state of the link; safe from any thread.
  [[nodiscard]] virtual LinkState link() const noexcept = 0;
  [[nodiscard]] virtual const SourceCounters& counters() const noexcept = 0;

  /// Call a few times a second from one thread that is not the beat: reopens interfaces that
  /// disappeared. May allocate and make system calls; never throws.
  virtual void maintain() noexcept {}

  /// Warnings for the user since the source was opened, in order: the first of each kind, one line.
  /// The list only grows. Call from the thread that calls `maintain`.
  [[nodiscard]] virtual std::vector<std::string> warnings() const { return {}; }

  /// The name that the user gave: "can0", "drive.log", "-".
  [[nodiscard]] virtual const std::string& name() const noexcept = 0;
};

}  // namespace odomd::can
