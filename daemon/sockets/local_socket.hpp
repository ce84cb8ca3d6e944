// A listening Unix socket in the file system: it has its mode and group before anyone can connect,
// and replaces the file of a dead process, but not the file of a running one.
#pragma once

#include <sys/socket.h>
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/file_descriptor.hpp"
#include "daemon/core/config.hpp"

namespace odomd::daemon {

enum class SocketType : int { stream = SOCK_STREAM, packets = SOCK_SEQPACKET };

struct LocalSocketSettings {
  SocketConfig file;
  SocketType type = SocketType::stream;
  std::string fix = "name another path";  ///< advice when the socket cannot be created there
};

/// A socket with this path, for the process's user and group.
[[nodiscard]] inline SocketConfig socket_at(const std::filesystem::path& path) {
  SocketConfig socket;
  socket.path = path;
  return socket;
}

/// Listens while it lives; the destructor removes its file, but no other file of that name.
class LocalSocket {
 public:
  /// Creates the directory when only its last part is missing. Throws std::invalid_argument for an
  /// impossible path or group, std::runtime_error when a file is in the way, another process
  /// listens there, or the machine refuses.
  explicit LocalSocket(const LocalSocketSettings& settings);
  ~LocalSocket();
  LocalSocket(LocalSocket&& other) noexcept = default;
  LocalSocket& operator=(LocalSocket&&) = delete;
  LocalSocket(const LocalSocket&) = delete;
  LocalSocket& operator=(const LocalSocket&) = delete;

  [[nodiscard]] int get() const noexcept { return descriptor_.get(); }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return settings_.file.path; }

  /// A connection, non-blocking and close-on-exec; empty when none is waiting.
  [[nodiscard]] FileDescriptor accept() const noexcept;

  /// Listens anew if its file was removed or replaced; false if it is in place. Throws as the
  /// constructor does, and then still listens as before.
  bool renew();

 private:
  [[nodiscard]] bool is_in_place() const noexcept;

  LocalSocketSettings settings_;
  dev_t device_ = 0;  // with the inode: identifies our file
  ino_t inode_ = 0;
  FileDescriptor descriptor_;
};

/// The id of a group. Throws std::invalid_argument when the group does not exist.
[[nodiscard]] gid_t group_named(const std::string& name);

struct Peer {
  pid_t pid = 0;
  uid_t uid = static_cast<uid_t>(-1);  ///< -1 is nobody's
  gid_t gid = static_cast<gid_t>(-1);
};

/// The process at the other end, as reported by the kernel (SO_PEERCRED).
[[nodiscard]] Peer peer_of(int connection) noexcept;

/// Whether the peer may connect: root, our own user, members of `group` (primary, or supplementary
/// at the time of connecting: SO_PEERGROUPS), or anyone if the mode lets everyone write.
[[nodiscard]] bool peer_is_welcome(int connection, gid_t group, std::uint32_t mode);

}  // namespace odomd::daemon
