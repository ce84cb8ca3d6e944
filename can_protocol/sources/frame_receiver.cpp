#include "can_protocol/sources/frame_receiver.hpp"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace odomd::can {
namespace {

constexpr std::size_t control_size =
    CMSG_SPACE(sizeof(scm_timestamping)) + CMSG_SPACE(sizeof(std::uint32_t));

std::int64_t nanoseconds(const timespec& time) noexcept {
  return time.tv_sec * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

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

bool request_stamps(int socket, StampSource stamps) noexcept {
  int flags = SOF_TIMESTAMPING_SOFTWARE | SOF_TIMESTAMPING_RX_SOFTWARE;
  if (stamps == StampSource::hardware)
    flags |= SOF_TIMESTAMPING_RAW_HARDWARE | SOF_TIMESTAMPING_RX_HARDWARE;
  const int on = 1;
  return ::setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPING, &flags, sizeof flags) == 0 &&
         ::setsockopt(socket, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) == 0;
}

struct FrameReceiver::Buffers {
  struct alignas(cmsghdr) Control {
    std::array<unsigned char, control_size> bytes;
  };
  std::array<mmsghdr, max_frames_per_drain> messages{};
  std::array<iovec, max_frames_per_drain> vectors{};
  std::array<canfd_frame, max_frames_per_drain> frames{};
  std::array<Control, max_frames_per_drain> controls{};
};

FrameReceiver::FrameReceiver(std::uint8_t bus, StampSource stamps)
    : bus_(bus),
      stamps_(stamps),
      buffers_(std::make_unique<Buffers>()),
      used_(max_frames_per_drain) {
  for (std::size_t i = 0; i < max_frames_per_drain; ++i) {
    buffers_->vectors[i] = {&buffers_->frames[i], sizeof(canfd_frame)};
    msghdr& header = buffers_->messages[i].msg_hdr;
    header.msg_iov = &buffers_->vectors[i];
    header.msg_iovlen = 1;
    header.msg_control = &buffers_->controls[i];
  }
  wall_clock_.update(read_clocks());
}

FrameReceiver::~FrameReceiver() = default;

Received FrameReceiver::receive(int socket, std::span<Frame> frames,
                                SourceCounters& counters) noexcept {
  const std::size_t room = std::min(frames.size(), max_frames_per_drain);
  for (std::size_t i = 0; i < used_; ++i)
    buffers_->messages[i].msg_hdr.msg_controllen = control_size;
  const int got = ::recvmmsg(socket, buffers_->messages.data(), static_cast<unsigned>(room),
                             MSG_DONTWAIT, nullptr);
  const int error = got < 0 ? errno : 0;

  const ClockReading reading = read_clocks();
  const ClockEvent event = wall_clock_.update(reading);
  if (event == ClockEvent::stepped) counters.clock_steps.add();
  if (event == ClockEvent::suspended) counters.suspends.add();

  used_ = got < 0 ? 0 : static_cast<std::size_t>(got);
  if (used_ == room && room != 0) counters.carried_over.add();
  Received result;
  if (error != EAGAIN && error != EINTR) result.error = error;
  for (std::size_t i = 0; i < used_; ++i) {
    const Stamps stamps = read_control(i, counters);
    auto frame = from_kernel(buffers_->frames[i], buffers_->messages[i].msg_len);
    if (!frame) {
      counters.malformed.add();
    } else if (frame->kind == FrameKind::error) {
      count_error_frame(*frame, counters);
    } else {
      frame->bus = bus_;
      frame->time_ns = time_of(stamps, reading.after_ns, counters);
      frames[result.count++] = *frame;
    }
  }
  counters.received.add(result.count);
  return result;
}

FrameReceiver::Stamps FrameReceiver::read_control(std::size_t message,
                                                  SourceCounters& counters) noexcept {
  Stamps stamps;
  msghdr& header = buffers_->messages[message].msg_hdr;
  for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr;
       control = CMSG_NXTHDR(&header, control)) {
    if (control->cmsg_level != SOL_SOCKET) continue;
    if (control->cmsg_type == SCM_TIMESTAMPING) {
      scm_timestamping times{};
      std::memcpy(&times, CMSG_DATA(control), sizeof times);
      stamps.software_ns = nanoseconds(times.ts[0]);
      stamps.hardware_ns = nanoseconds(times.ts[2]);
    } else if (control->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t total = 0;
      std::memcpy(&total, CMSG_DATA(control), sizeof total);
      counters.lost.add(drops_.grown_to(total));
    }
  }
  return stamps;
}

std::int64_t FrameReceiver::time_of(const Stamps& stamps, std::int64_t now_ns,
                                    SourceCounters& counters) noexcept {
  std::int64_t time = now_ns;
  if (const auto software = stamps.software_ns > 0
                                ? wall_clock_.to_monotonic(stamps.software_ns, now_ns)
                                : std::nullopt)
    time = *software;
  else
    counters.stamp_fallbacks.add();
  if (stamps_ == StampSource::software) return time;
  if (stamps.hardware_ns > 0) return device_clock_.to_monotonic(stamps.hardware_ns, time);
  counters.hardware_fallbacks.add();
  return time;
}

}  // namespace odomd::can
