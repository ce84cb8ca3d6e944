// A Unix socket in the file system that listens: made with its mode and group before anyone can
// connect, a dead predecessor's file replaced, a living one's left alone.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "base/file_descriptor.hpp"

namespace odomd::daemon {

enum class SocketType : std::uint8_t { stream, packets };  // SOCK_STREAM, SOCK_SEQPACKET

struct LocalSocketSettings {
  std::filesystem::path path;
  SocketType type = SocketType::stream;
  std::uint32_t mode = 0660;
  std::string group;                       ///< of the file; empty: the process's
  std::string mend = "name another path";  ///< said where the socket cannot be made there
};

/// Listens while it lives; takes its file away when it goes, and no other of that name.
class LocalSocket {
 public:
  /// Makes the directory where only the last part of it is missing. Throws std::invalid_argument
  /// for a path or group that cannot be, std::runtime_error where something is in the way, someone
  /// else listens there, or the machine refuses.
  explicit LocalSocket(const LocalSocketSettings& settings);
  ~LocalSocket();
  LocalSocket(LocalSocket&& other) noexcept = default;
  LocalSocket& operator=(LocalSocket&&) = delete;
  LocalSocket(const LocalSocket&) = delete;
  LocalSocket& operator=(const LocalSocket&) = delete;

  [[nodiscard]] int get() const noexcept { return descriptor_.get(); }
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }

  /// A connection, non-blocking and close-on-exec; empty where none waits.
  [[nodiscard]] FileDescriptor accept() const noexcept;

 private:
  std::filesystem::path path_;
  dev_t device_ = 0;  // with the inode: which file is ours
  ino_t inode_ = 0;
  FileDescriptor descriptor_;
};

/// The group's number. Throws std::invalid_argument where there is none of this name.
[[nodiscard]] gid_t group_named(const std::string& name);

struct Peer {
  pid_t pid = 0;
  uid_t uid = 0;
};

/// Who is at the other end, as the kernel vouches for it (SO_PEERCRED).
[[nodiscard]] std::optional<Peer> peer_of(int connection) noexcept;

/// Root, our own user, members of `group` (primary, or supplementary when they connected:
/// SO_PEERGROUPS), and anyone where the mode lets everyone write.
[[nodiscard]] bool peer_is_welcome(int connection, gid_t group, std::uint32_t mode);

}  // namespace odomd::daemon
