// Converts frames of the kernel, and builds its filters.
#pragma once

#include <linux/can.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "can_protocol/frame.hpp"
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

}  // namespace odomd::can
