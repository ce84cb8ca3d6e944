#include "daemon/sockets/camera_server.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <utility>

namespace odomd::daemon {
namespace {

static_assert(sizeof(odom_camera_message) == 80);
static_assert(std::endian::native == std::endian::little, "the wire is little-endian");

/// Beyond this (73 years) differences of times could overflow.
constexpr std::int64_t latest_ns = std::int64_t{1} << 61;

/// The capture time on CLOCK_MONOTONIC, or the reason why there is none. A picture may be older
/// than a step of the wall clock: its stamp is converted with the offset of that time. If no
/// offset gives a recent time, the current offset is used, and the filter then gives its verdict.
MalformedCause convert(const odom_camera_message& message, const MessageClocks& clocks,
                       std::int64_t arrival_ns, std::int64_t& capture_ns) noexcept {
  std::int64_t offset_ns = 0;
  switch (message.clock) {
    case ODOM_CLOCK_MONOTONIC:
      break;
    case ODOM_CLOCK_REALTIME:
      offset_ns = clocks.wall.offset_ns();
      break;
    case ODOM_CLOCK_LOG:
      if (!clocks.log_ns) return MalformedCause::no_log;
      offset_ns = *clocks.log_ns;
      break;
    default:
      return MalformedCause::clock;
  }
  if (__builtin_sub_overflow(message.capture_ns, offset_ns, &capture_ns) ||
      capture_ns > latest_ns || capture_ns < -latest_ns)
    return MalformedCause::time;
  if (message.clock == ODOM_CLOCK_REALTIME)
    capture_ns = clocks.wall.to_monotonic(message.capture_ns, arrival_ns).value_or(capture_ns);
  return MalformedCause::none;
}

}  // namespace

CameraMessage read_camera_message(std::span<const std::byte> bytes, std::size_t size,
                                  const MessageClocks& clocks, std::int64_t arrival_ns) noexcept {
  odom_camera_message message;
  if (size != sizeof message || bytes.size() < sizeof message) return {MalformedCause::size, {}};
  std::memcpy(&message, bytes.data(), sizeof message);
  if (message.magic != ODOM_CAMERA_MAGIC) return {MalformedCause::magic, {}};
  if (message.version != ODOM_CAMERA_VERSION) return {MalformedCause::version, {}};
  if (message.reserved != 0) return {MalformedCause::reserved, {}};

  std::int64_t capture_ns = 0;
  if (const auto cause = convert(message, clocks, arrival_ns, capture_ns);
      cause != MalformedCause::none)
    return {cause, {}};
  return {MalformedCause::none,
          {.capture_ns = capture_ns,
           .arrival_ns = arrival_ns,
           .x = message.x,
           .y = message.y,
           .yaw = message.yaw,
           .sigma_x = message.sigma_x,
           .sigma_y = message.sigma_y,
           .sigma_yaw = message.sigma_yaw}};
}

CameraServer::~CameraServer() {
  for (auto& slot : slots_) {
    const int state = slot.state.load(std::memory_order_acquire);
    if (state != Slot::free) ::close(state >= 0 ? state : Slot::ended(state));
  }
}

CameraServer::Drained CameraServer::drain(std::span<estimator::CameraPose> poses,
                                          const MessageClocks& clocks, std::int64_t now_ns,
                                          EventRing& events) noexcept {
  Drained drained;
  for (Slot& slot : slots_) {
    // Acquire: the counters were reset before the descriptor was handed over.
    const int descriptor = slot.state.load(std::memory_order_acquire);
    if (descriptor < 0) continue;
    for (std::size_t message = 0; message < max_messages_per_drain; ++message) {
      const auto received = receive(descriptor, clocks, now_ns, poses[drained.poses], events);
      if (received == Received::nothing) break;
      if (received == Received::ended) {
        // Release: housekeeping closes it, and the beat does not touch it again.
        slot.state.store(Slot::ended(descriptor), std::memory_order_release);
        events.push({EventKind::camera_gone});
        break;
      }
      slot.messages.add();
      if (received == Received::pose) {
        slot.heard_ns.set(static_cast<std::uint64_t>(now_ns));
        ++drained.poses;
      } else {
        slot.malformed.add();
        ++drained.malformed;
      }
    }
  }
  return drained;
}

CameraServer::Received CameraServer::receive(int descriptor, const MessageClocks& clocks,
                                             std::int64_t now_ns, estimator::CameraPose& pose,
                                             EventRing& events) noexcept {
  std::array<std::byte, sizeof(odom_camera_message)> bytes;
  iovec part{bytes.data(), bytes.size()};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  // MSG_TRUNC: returns the true length, also of a message that is longer than `bytes`.
  const ssize_t size = ::recvmsg(descriptor, &header, MSG_DONTWAIT | MSG_TRUNC);
  if (size < 0) return errno == EAGAIN || errno == EINTR ? Received::nothing : Received::ended;
  if (size == 0) return Received::ended;
  const auto message = read_camera_message(bytes, static_cast<std::size_t>(size), clocks, now_ns);
  if (message.cause != MalformedCause::none) {
    events.push({EventKind::camera_malformed, static_cast<std::int64_t>(message.cause)});
    return Received::malformed;
  }
  pose = message.pose;
  return Received::pose;
}

CameraServer::Admission CameraServer::admit(FileDescriptor connection, Peer peer,
                                            std::int64_t now_ns) {
  Slot* idlest = nullptr;
  for (auto& slot : slots_) {
    const int state = slot.state.load(std::memory_order_acquire);
    if (state == Slot::free) {
      open(slot, std::move(connection), peer, now_ns);
      return Admission::free_slot;
    }
    const auto heard_ns = static_cast<std::int64_t>(slot.heard_ns.get());
    if (state >= 0 && !slot.successor && now_ns - heard_ns >= idle_ns &&
        (idlest == nullptr || slot.heard_ns.get() < idlest->heard_ns.get()))
      idlest = &slot;
  }
  if (idlest == nullptr) {
    refuse(std::move(connection), -EBUSY);
    return Admission::refused;
  }
  // The beat may be reading this socket. After it sees the shutdown, close_ended() closes and
  // replaces the socket.
  ::shutdown(idlest->state.load(std::memory_order_relaxed), SHUT_RDWR);
  idlest->successor = std::move(connection);
  idlest->successor_peer = peer;
  return Admission::in_place_of_idle;
}

void CameraServer::refuse(FileDescriptor connection, std::int32_t reason) noexcept {
  static_cast<void>(::send(connection.get(), &reason, sizeof reason, MSG_NOSIGNAL | MSG_DONTWAIT));
  connection = {};
  refused_.add();
}

void CameraServer::open(Slot& slot, FileDescriptor connection, Peer peer,
                        std::int64_t now_ns) noexcept {
  slot.peer = peer;
  slot.messages.set(0);
  slot.malformed.set(0);
  slot.heard_ns.set(static_cast<std::uint64_t>(now_ns));
  slot.state.store(connection.release(), std::memory_order_release);
}

void CameraServer::close_ended(std::int64_t now_ns) noexcept {
  for (auto& slot : slots_) {
    const int state = slot.state.load(std::memory_order_acquire);
    if (state >= Slot::free) continue;
    ::close(Slot::ended(state));
    if (slot.successor) {
      open(slot, std::exchange(slot.successor, {}), slot.successor_peer, now_ns);
    } else {
      slot.state.store(Slot::free, std::memory_order_relaxed);
    }
  }
}

std::array<CameraServer::Connection, CameraServer::max_connections> CameraServer::connections()
    const {
  std::array<Connection, max_connections> all;
  for (std::size_t i = 0; i < max_connections; ++i) {
    const Slot& slot = slots_[i];
    all[i] = {slot.state.load(std::memory_order_acquire) >= 0, slot.peer, slot.messages.get(),
              slot.malformed.get()};
  }
  return all;
}

}  // namespace odomd::daemon
