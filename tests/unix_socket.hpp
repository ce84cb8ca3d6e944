// Unix sockets for tests: one that listens in place of the daemon, one that connects to it.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <stdexcept>
#include <string>

#include "base/file_descriptor.hpp"

namespace odomd {

[[nodiscard]] inline sockaddr_un unix_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  return address;
}

/// A socket of this type that listens at `path`.
[[nodiscard]] inline FileDescriptor listening_socket(const std::string& path, int type) {
  FileDescriptor socket{::socket(AF_UNIX, type | SOCK_CLOEXEC, 0)};
  const sockaddr_un address = unix_address(path);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket.get(), 4) != 0)
    throw std::runtime_error("cannot listen at " + path);
  return socket;
}

/// A socket of this type that is connected to `path`; none if nobody listens there.
[[nodiscard]] inline FileDescriptor connected_socket(const std::string& path, int type) {
  FileDescriptor socket{::socket(AF_UNIX, type | SOCK_CLOEXEC, 0)};
  const sockaddr_un address = unix_address(path);
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return {};
  return socket;
}

}  // namespace odomd
