// A Unix socket of the test's own, in place of the daemon's.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <stdexcept>
#include <string>

#include "base/file_descriptor.hpp"

namespace odomd {

/// A socket of this type that listens at `path`.
[[nodiscard]] inline FileDescriptor listening_socket(const std::string& path, int type) {
  FileDescriptor socket{::socket(AF_UNIX, type | SOCK_CLOEXEC, 0)};
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  if (::bind(socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(socket.get(), 4) != 0)
    throw std::runtime_error("cannot listen at " + path);
  return socket;
}

}  // namespace odomd
