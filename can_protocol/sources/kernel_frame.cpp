#include "can_protocol/sources/kernel_frame.hpp"

#include <linux/can/error.h>
#include <linux/can/raw.h>

#include <algorithm>
#include <cstring>

namespace odomd::can {

std::optional<Frame> from_kernel(const canfd_frame& raw, std::size_t bytes) noexcept {
  const bool fd = bytes == CANFD_MTU;
  if (!fd && bytes != CAN_MTU) return std::nullopt;
  if (fd ? !is_fd_length(raw.len) : raw.len > CAN_MAX_DLEN) return std::nullopt;
  // CAN FD has no remote frames, but a virtual bus passes them.
  if (fd && (raw.can_id & CAN_RTR_FLAG) != 0 && (raw.can_id & CAN_ERR_FLAG) == 0)
    return std::nullopt;

  Frame frame;
  frame.length = raw.len;
  if (fd) {
    frame.protocol = FrameProtocol::fd;
    frame.fd_flags = raw.flags & (CANFD_BRS | CANFD_ESI);
  }
  if ((raw.can_id & CAN_ERR_FLAG) != 0) {
    frame.kind = FrameKind::error;
    frame.id = raw.can_id & CAN_ERR_MASK;
  } else if ((raw.can_id & CAN_EFF_FLAG) != 0) {
    frame.format = IdFormat::extended;
    frame.id = raw.can_id & CAN_EFF_MASK;
  } else {
    frame.id = raw.can_id & CAN_SFF_MASK;
  }
  if (frame.kind == FrameKind::data && (raw.can_id & CAN_RTR_FLAG) != 0)
    frame.kind = FrameKind::remote;
  else
    std::memcpy(frame.data.data(), raw.data, raw.len);
  return frame;
}

void count_error_frame(const Frame& frame, SourceCounters& counters) noexcept {
  counters.error_frames.add();
  if ((frame.id & CAN_ERR_BUSOFF) != 0) counters.bus_offs.add();
  if ((frame.id & CAN_ERR_CRTL) != 0 && (frame.data[1] & CAN_ERR_CRTL_RX_OVERFLOW) != 0)
    counters.controller_overflows.add();
}

std::vector<can_filter> exact_filters(std::span<const std::uint32_t> keys) {
  std::vector<std::uint32_t> sorted(keys.begin(), keys.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  std::vector<can_filter> filters;
  if (sorted.size() > CAN_RAW_FILTER_MAX) return filters;
  for (const std::uint32_t key : sorted) {
    const bool extended = (key & CAN_EFF_FLAG) != 0;  // frame_key has the kernel's flag
    const std::uint32_t mask = (key & j1939_group_flag) != 0 ? j1939_group_mask(key)
                               : extended                    ? CAN_EFF_MASK
                                                             : CAN_SFF_MASK;
    filters.push_back({key & (CAN_EFF_FLAG | mask), CAN_EFF_FLAG | CAN_RTR_FLAG | mask});
  }
  return filters;
}

}  // namespace odomd::can
