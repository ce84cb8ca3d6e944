// A frame as the kernel hands it out, and the filters it is asked to apply.
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

/// The frame in `raw`, of which the kernel wrote `bytes`; nothing when that is no classic CAN or
/// CAN FD frame. Time and bus are left alone. Real-time safe.
[[nodiscard]] std::optional<Frame> from_kernel(const canfd_frame& raw, std::size_t bytes) noexcept;

/// Counts an error frame, and what it says. Real-time safe.
void count_error_frame(const Frame& frame, SourceCounters& counters) noexcept;

/// Exact filters for data frames of the given identifiers (frame_key), sorted, each once. Empty,
/// which means every frame, when `keys` is empty or there are more than the kernel takes.
[[nodiscard]] std::vector<can_filter> exact_filters(std::span<const std::uint32_t> keys);

/// What the kernel's count of dropped frames, 32 bits that wrap, has grown by.
class DropCount {
 public:
  std::uint32_t grown_to(std::uint32_t total) noexcept {
    const std::uint32_t growth = total - last_;
    last_ = total;
    return growth;
  }
  /// A fresh socket counts from 0.
  void restart() noexcept { last_ = 0; }

 private:
  std::uint32_t last_ = 0;
};

}  // namespace odomd::can
