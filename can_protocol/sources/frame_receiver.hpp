// Receives many frames and their times from a raw CAN socket with one system call.
#pragma once

#include <linux/can.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/wall_clock.hpp"
#include "can_protocol/frame.hpp"
#include "can_protocol/sources/device_clock.hpp"
#include "can_protocol/sources/frame_source.hpp"

namespace odomd::can {

/// The frame in `raw`, into which the kernel wrote `bytes` bytes; empty when it is neither a
/// classic CAN nor a CAN FD frame. Does not set time and bus. Real-time safe.
[[nodiscard]] std::optional<Frame> from_kernel(const canfd_frame& raw, std::size_t bytes) noexcept;

/// Counts an error frame and the errors that it reports. Real-time safe.
void count_error_frame(const Frame& frame, SourceCounters& counters) noexcept;

/// Exact filters for data frames of the given identifiers (frame_key, or its J1939 group), sorted
/// and unique. Empty, which means every frame, when `keys` is empty or has more identifiers than
/// the kernel accepts.
[[nodiscard]] std::vector<can_filter> exact_filters(std::span<const std::uint32_t> keys);

/// The growth of the kernel's 32-bit, wrapping count of dropped frames.
class DropCount {
 public:
  std::uint32_t grown_to(std::uint32_t total) noexcept {
    const std::uint32_t growth = total - last_;
    last_ = total;
    return growth;
  }
  /// A new socket counts from 0.
  void restart() noexcept { last_ = 0; }

 private:
  std::uint32_t last_ = 0;
};

/// Which kernel time stamp is the time of a frame.
enum class StampSource : std::uint8_t { software, hardware };

/// Enables what a receiver reads with each frame: time stamps and the count of drops. Returns
/// false, with errno set, when the kernel refuses.
[[nodiscard]] bool request_stamps(int socket, StampSource stamps) noexcept;

struct Received {
  std::size_t count = 0;  ///< frames delivered
  int error = 0;          ///< errno of the socket; 0: no error
};

/// The buffers are allocated once; `receive` is real-time safe: one recvmmsg that does not block,
/// and reading the clocks. For use by one thread.
class FrameReceiver {
 public:
  FrameReceiver(std::uint8_t bus, StampSource stamps);
  ~FrameReceiver();
  FrameReceiver(const FrameReceiver&) = delete;
  FrameReceiver& operator=(const FrameReceiver&) = delete;

  /// Moves at most max_frames_per_drain frames from the socket to `frames`, with times on
  /// CLOCK_MONOTONIC, and counts them. Error frames are counted, but not delivered. A frame without
  /// a plausible stamp gets the time of this call.
  Received receive(int socket, std::span<Frame> frames, SourceCounters& counters) noexcept;

  /// Call before reading from another socket, whose count of drops starts at 0.
  void restart() noexcept { drops_.restart(); }

 private:
  struct Stamps {
    std::int64_t software_ns = 0;  // CLOCK_REALTIME, 0: none
    std::int64_t hardware_ns = 0;  // the controller's clock, 0: none
  };
  struct Buffers;

  Stamps read_control(std::size_t message, SourceCounters& counters) noexcept;
  std::int64_t time_of(const Stamps& stamps, std::int64_t now_ns,
                       SourceCounters& counters) noexcept;

  std::uint8_t bus_;
  StampSource stamps_;
  std::unique_ptr<Buffers> buffers_;
  std::size_t used_;  // number of messages whose control length the kernel has overwritten
  WallClock wall_clock_;
  DeviceClock device_clock_;
  DropCount drops_;
};

}  // namespace odomd::can
