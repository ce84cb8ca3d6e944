#include "daemon/sockets/local_socket.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace odomd::daemon {
namespace {

constexpr int backlog = 16;

[[noreturn]] void refuse(const std::filesystem::path& path, std::string_view what) {
  throw std::runtime_error(fmt::format("{}: {}", path.string(), what));
}

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view doing) {
  throw std::system_error(errno, std::generic_category(),
                          fmt::format("{}: {}", path.string(), doing));
}

sockaddr_un address_of(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.native().size() >= sizeof address.sun_path)
    throw std::invalid_argument(
        fmt::format("{}: is too long for a socket; the limit is {} characters", path.string(),
                    sizeof address.sun_path - 1));
  path.native().copy(address.sun_path, path.native().size());
  return address;
}

const sockaddr* generic(const sockaddr_un& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

/// A socket that does not block.
FileDescriptor make_socket(SocketType type) {
  return FileDescriptor(
      ::socket(AF_UNIX, static_cast<int>(type) | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

/// Makes the directory: after a boot it is gone from /run.
void make_directory(const LocalSocketSettings& settings) {
  const std::filesystem::path& path = settings.file.path;
  const auto directory = path.parent_path();
  std::error_code error;
  if (std::filesystem::is_directory(directory, error)) return;
  if (::mkdir(directory.c_str(), 0755) != 0)
    refuse(path,
           fmt::format("the directory {} is missing and cannot be created: {}; create it, or {}",
                       directory.string(), std::strerror(errno), settings.fix));
}

/// Removes a socket on which nobody listens any more.
void remove_stale(const LocalSocketSettings& settings, const sockaddr_un& address) {
  struct stat status {};
  if (::lstat(settings.file.path.c_str(), &status) != 0) return;
  if (!S_ISSOCK(status.st_mode))
    refuse(settings.file.path, "exists and is not a socket; remove it or choose another name");
  const FileDescriptor probe = make_socket(settings.type);
  if (::connect(probe.get(), generic(address), sizeof address) == 0 || errno != ECONNREFUSED)
    refuse(settings.file.path, "another program is listening there; is odomd already running?");
  if (::unlink(settings.file.path.c_str()) != 0)
    fail(settings.file.path, "cannot remove the old socket");
}

}  // namespace

LocalSocket::LocalSocket(const LocalSocketSettings& settings) : settings_(settings) {
  const std::filesystem::path& path = settings_.file.path;
  const sockaddr_un address = address_of(path);
  // As for chown, -1 changes nothing.
  const gid_t group =
      settings.file.group.empty() ? static_cast<gid_t>(-1) : group_named(settings.file.group);
  make_directory(settings);
  remove_stale(settings, address);

  FileDescriptor descriptor = make_socket(settings.type);
  if (!descriptor) fail(path, "cannot create a socket");
  if (::bind(descriptor.get(), generic(address), sizeof address) != 0)
    refuse(path, fmt::format("cannot be created: {}; {}", std::strerror(errno), settings.fix));
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) fail(path, "cannot be found again");
  device_ = status.st_dev;
  inode_ = status.st_ino;
  descriptor_ = std::move(descriptor);
  // Nobody can connect before listen(), so mode and group are set in time. The unit's system call
  // filter allows fchownat, not lchown.
  if (::fchownat(AT_FDCWD, path.c_str(), static_cast<uid_t>(-1), group, AT_SYMLINK_NOFOLLOW) != 0)
    fail(path, fmt::format("cannot give it to the group {}", settings.file.group));
  if (::chmod(path.c_str(), settings.file.mode) != 0) fail(path, "cannot set its mode");
  if (::listen(descriptor_.get(), backlog) != 0) fail(path, "cannot listen");
}

LocalSocket::~LocalSocket() {
  // Our file may have been removed, and another daemon may be listening under its name.
  if (descriptor_ && is_in_place()) ::unlink(path().c_str());
}

bool LocalSocket::is_in_place() const noexcept {
  struct stat status {};
  return ::lstat(path().c_str(), &status) == 0 && status.st_dev == device_ &&
         status.st_ino == inode_;
}

bool LocalSocket::renew() {
  if (is_in_place()) return false;
  LocalSocket successor(settings_);
  std::swap(device_, successor.device_);
  std::swap(inode_, successor.inode_);
  std::swap(descriptor_, successor.descriptor_);
  return true;
}

FileDescriptor LocalSocket::accept() const noexcept {
  return FileDescriptor(
      ::accept4(descriptor_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
}

gid_t group_named(const std::string& name) {
  std::vector<char> buffer(1 << 16);
  group entry{};
  group* found = nullptr;
  ::getgrnam_r(name.c_str(), &entry, buffer.data(), buffer.size(), &found);
  if (found == nullptr)
    throw std::invalid_argument(
        fmt::format("there is no group \"{}\" on this machine; create it with groupadd", name));
  return entry.gr_gid;
}

Peer peer_of(int connection) noexcept {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return {};
  return {credentials.pid, credentials.uid, credentials.gid};
}

bool peer_is_welcome(int connection, gid_t group, std::uint32_t mode) {
  const Peer peer = peer_of(connection);
  if (peer.uid == 0 || peer.uid == ::geteuid()) return true;
  if ((mode & S_IWOTH) != 0 || peer.gid == group) return true;
  std::vector<gid_t> groups(1 << 10);
  auto size = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
  if (::getsockopt(connection, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) != 0) return false;
  groups.resize(size / sizeof(gid_t));
  return std::ranges::find(groups, group) != groups.end();
}

}  // namespace odomd::daemon
