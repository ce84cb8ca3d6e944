#include "daemon/sockets/camera_door.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace odomd::daemon {

CameraDoor::~CameraDoor() {
  for (auto& slot : slots_) {
    const int state = slot.state.load(std::memory_order_acquire);
    if (state != Slot::free) ::close(state >= 0 ? state : Slot::ended(state));
  }
}

CameraDoor::Drained CameraDoor::drain(std::span<estimator::CameraPose> poses,
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

CameraDoor::Received CameraDoor::receive(int descriptor, const MessageClocks& clocks,
                                         std::int64_t now_ns, estimator::CameraPose& pose,
                                         EventRing& events) noexcept {
  std::array<std::byte, sizeof(odom_camera_message)> bytes;
  iovec part{bytes.data(), bytes.size()};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  // MSG_TRUNC: the true length of a message that is longer than ours.
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

CameraDoor::Admission CameraDoor::admit(FileDescriptor connection, Peer peer, std::int64_t now_ns) {
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
  // The beat may be reading this socket: it sees the shutdown, and close_ended() closes and
  // replaces the socket.
  ::shutdown(idlest->state.load(std::memory_order_relaxed), SHUT_RDWR);
  idlest->successor = std::move(connection);
  idlest->successor_peer = peer;
  return Admission::in_place_of_idle;
}

void CameraDoor::refuse(FileDescriptor connection, std::int32_t reason) noexcept {
  static_cast<void>(::send(connection.get(), &reason, sizeof reason, MSG_NOSIGNAL | MSG_DONTWAIT));
  connection = {};
  refused_.add();
}

void CameraDoor::open(Slot& slot, FileDescriptor connection, Peer peer,
                      std::int64_t now_ns) noexcept {
  slot.peer = peer;
  slot.messages.set(0);
  slot.malformed.set(0);
  slot.heard_ns.set(static_cast<std::uint64_t>(now_ns));
  slot.state.store(connection.release(), std::memory_order_release);
}

void CameraDoor::close_ended(std::int64_t now_ns) noexcept {
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

std::array<CameraDoor::Connection, CameraDoor::max_connections> CameraDoor::connections() const {
  std::array<Connection, max_connections> all;
  for (std::size_t i = 0; i < max_connections; ++i) {
    const Slot& slot = slots_[i];
    all[i] = {slot.state.load(std::memory_order_acquire) >= 0, slot.peer, slot.messages.get(),
              slot.malformed.get()};
  }
  return all;
}

}  // namespace odomd::daemon
