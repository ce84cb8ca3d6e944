#include "can_protocol/sources/socketcan.hpp"

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace odomd::can {
namespace {

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

ifreq request_for(const std::string& interface) {
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  return request;
}

template <typename Value>
int set(int socket, int level, int option, const Value& value) {
  return ::setsockopt(socket, level, option, &value, sizeof value);
}

/// 0 when the interface does not exist.
int index_of(int control, const std::string& interface) {
  ifreq request = request_for(interface);
  return ::ioctl(control, SIOCGIFINDEX, &request) == 0 ? request.ifr_ifindex : 0;
}

LinkState state_of(int control, const std::string& interface) {
  ifreq request = request_for(interface);
  if (::ioctl(control, SIOCGIFFLAGS, &request) != 0) return LinkState::gone;
  return (request.ifr_flags & IFF_UP) != 0 ? LinkState::up : LinkState::down;
}

}  // namespace

SocketCanSource::SocketCanSource(std::string interface, SocketCanSettings settings)
    : interface_(std::move(interface)),
      settings_(std::move(settings)),
      receiver_(settings_.bus, settings_.stamps),
      control_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  if (!control_) fail(errno, interface_ + ": cannot open a socket to query the interface");
  // Fails now, not when the interface appears, if the kernel has no CAN.
  const FileDescriptor probe(::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  if (!probe)
    fail(errno,
         interface_ +
             ": this kernel has no CAN sockets; load the module (modprobe can-raw), or give a "
             "candump log or - instead");
  connect();
  adopt_offered();
}

SocketCanSource::~SocketCanSource() {
  close_retired();
  for (const int descriptor : {offered_.load(), socket_})
    if (descriptor != none) ::close(descriptor);
}

// The beat's side ---------------------------------------------------------------------------------

std::size_t SocketCanSource::drain(std::span<Frame> frames, std::int64_t /*tick_ns*/,
                                   std::int64_t /*now_ns*/) noexcept {
  adopt_offered();
  if (socket_ == none) return 0;
  const Received received = receiver_.receive(socket_, frames, counters_);
  if (received.error != 0) note_error(received.error);
  return received.count;
}

void SocketCanSource::adopt_offered() noexcept {
  if (offered_.load(std::memory_order_relaxed) == none) return;
  // The slot for the old socket must be free, because the beat does not close sockets.
  if (socket_ != none && retired_.load(std::memory_order_acquire) != none) return;
  const int fresh = offered_.exchange(none, std::memory_order_acq_rel);
  if (fresh == none) return;
  if (socket_ != none) retired_.store(socket_, std::memory_order_release);
  socket_ = fresh;
  receiver_.restart();
}

void SocketCanSource::note_error(int error) noexcept {
  // ENETDOWN: the interface is down, the socket stays bound. ENODEV: unregistered, the socket is
  // dead.
  if (error != ENETDOWN && error != ENODEV) return;
  counters_.link_downs.add();
  link_.store(error == ENODEV ? LinkState::gone : LinkState::down, std::memory_order_relaxed);
  if (error == ENODEV) dead_.store(socket_, std::memory_order_release);
}

// Housekeeping's side -----------------------------------------------------------------------------

void SocketCanSource::maintain() noexcept {
  try {
    close_retired();
    connect();
  } catch (const std::exception& error) {
    link_.store(LinkState::gone, std::memory_order_relaxed);
    warnings_.add(SourceWarning::failure, error.what());
  }
}

void SocketCanSource::connect() {
  const int index = index_of(control_.get(), interface_);
  if (index == 0) {
    bound_index_ = 0;
    link_.store(LinkState::gone, std::memory_order_relaxed);
    return;
  }
  const bool dead = newest_ != none && dead_.load(std::memory_order_acquire) == newest_;
  if (index != bound_index_ || dead) {
    offer(open_socket(index));
    bound_index_ = index;
  }
  link_.store(state_of(control_.get(), interface_), std::memory_order_relaxed);
}

FileDescriptor SocketCanSource::open_socket(int index) {
  ifreq request = request_for(interface_);
  if (::ioctl(control_.get(), SIOCGIFHWADDR, &request) == 0 &&
      request.ifr_hwaddr.sa_family != ARPHRD_CAN)
    throw std::invalid_argument(interface_ +
                                ": not a CAN interface; `ip link show type can` lists those");

  FileDescriptor socket(::socket(AF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  if (!socket) fail(errno, interface_ + ": cannot open a CAN socket");
  const int fd = socket.get();

  const std::vector<can_filter> filters = exact_filters(settings_.keys);
  if (!filters.empty() &&
      ::setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                   static_cast<socklen_t>(filters.size() * sizeof(can_filter))) != 0)
    fail(errno, interface_ + ": the kernel refuses the identifier filters");
  if (set(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK}) != 0)
    fail(errno, interface_ + ": the kernel refuses error frames");
  if (set(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, int{1}) != 0)
    fail(errno, interface_ + ": the kernel refuses CAN FD frames");
  if (!request_stamps(fd, settings_.stamps))
    fail(errno, interface_ + ": the kernel refuses time stamps");

  // A size beyond net.core.rmem_max needs CAP_NET_ADMIN. The kernel doubles the requested size.
  if (set(fd, SOL_SOCKET, SO_RCVBUFFORCE, settings_.receive_buffer) != 0)
    set(fd, SOL_SOCKET, SO_RCVBUF, settings_.receive_buffer);
  int granted = 0;
  socklen_t size = sizeof granted;
  ::getsockopt(fd, SOL_SOCKET, SO_RCVBUF, &granted, &size);
  if (granted / 2 < settings_.receive_buffer)
    warnings_.add(SourceWarning::small_buffer,
                  interface_ + ": the receive buffer is " + std::to_string(granted / 2) +
                      " bytes, not " + std::to_string(settings_.receive_buffer) +
                      "; raise net.core.rmem_max, or grant CAP_NET_ADMIN");

  // Raw CAN sockets do not support half-close (yet); if one does, this closes the sending side.
  ::shutdown(fd, SHUT_WR);

  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  // bind() needs this cast for every kind of socket.
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    fail(errno, interface_ + ": cannot bind to the interface");
  // On an interface that is down, the socket starts with ENETDOWN pending: this read clears it.
  int pending = 0;
  size = sizeof pending;
  ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &pending, &size);
  return socket;
}

void SocketCanSource::offer(FileDescriptor socket) {
  newest_ = socket.release();
  const int unclaimed = offered_.exchange(newest_, std::memory_order_acq_rel);
  if (unclaimed != none) ::close(unclaimed);
}

void SocketCanSource::close_retired() noexcept {
  const int retired = retired_.exchange(none, std::memory_order_acq_rel);
  if (retired == none) return;
  // The next socket may get the same number, so forget that this one was dead.
  int dead = retired;
  dead_.compare_exchange_strong(dead, none, std::memory_order_acq_rel);
  ::close(retired);
}

}  // namespace odomd::can
