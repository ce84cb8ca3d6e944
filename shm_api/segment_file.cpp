#include "shm_api/segment_file.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "shm_api/layout/segment.h"
#include "shm_api/libodom/attach.h"

namespace odomd::shm {
namespace {

// A name that is impossible on any machine is a user error; all else the machine's.
[[noreturn]] void fail(const std::string& path, const std::string& what) {
  const int error = errno;
  if (error == ENOENT || error == ENOTDIR)
    throw std::runtime_error(path.substr(0, path.rfind('/')) +
                             ": no such directory: create it, or set another in [shm] name");
  if (error == ENAMETOOLONG) throw std::invalid_argument(path + ": too long for a [shm] name");
  std::string why = path + ": cannot " + what;
  // Everyone may write to directories like /dev/shm, so the file may belong to another user.
  if (error == EACCES || error == EPERM)
    why += ": if it is another user's, remove it or set another [shm] name";
  throw std::system_error(error, std::generic_category(), why);
}

// A lock contains the pid of its owner and a line feed; a new lock is empty.
constexpr std::size_t longest_owner = 24;

std::string text_of(int file) {
  std::array<char, longest_owner + 1> text{};
  const ssize_t length = pread(file, text.data(), text.size(), 0);
  return {text.data(), length > 0 ? static_cast<std::size_t>(length) : 0};
}

std::string pid_in(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

bool is_lock_of_ours(const std::string& text) {
  const std::string pid = pid_in(text);
  return text.size() <= longest_owner && text.size() <= pid.size() + 1 &&
         std::all_of(pid.begin(), pid.end(), [](char c) { return c >= '0' && c <= '9'; });
}

[[noreturn]] void refuse_second_writer(const std::string& path, const std::string& pid) {
  throw Displaced(path + ": " + (pid.empty() ? "another process" : "process " + pid) +
                  " publishes there already: stop it, or set another [shm] name");
}

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISLNK(mode)) return "a link";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return S_ISREG(mode) ? "a file" : "a device";
}

enum class Unfinished { refused, taken };

/// A segment emptied by truncate(1): an empty file of ours with the lock of its writer.
bool is_emptied_segment(const std::string& path, const struct stat& status) {
  if (status.st_size != 0 || status.st_uid != geteuid() || (status.st_mode & 0022U) != 0)
    return false;
  struct stat lock_status {};
  const FileDescriptor lock(
      open((path + ".lock").c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
  if (!lock || fstat(lock.get(), &lock_status) != 0) return false;
  const std::string text = text_of(lock.get());
  return lock_status.st_uid == geteuid() && !text.empty() && is_lock_of_ours(text);
}

/// A writer running as root could replace any file, so it only replaces files that a writer has
/// left. The first word of an unfinished segment is still zero.
void require_segment_or_absent(const std::string& path, Unfinished unfinished) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) return;
    fail(path, "inspect it");
  }
  std::uint64_t magic = 0;
  ssize_t length = -1;
  if (S_ISREG(status.st_mode)) {
    const FileDescriptor file(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
    if (!file) fail(path, "read it");
    length = pread(file.get(), &magic, sizeof magic, 0);
    if (length < 0) fail(path, "read it");
  }
  const bool segment = length == sizeof magic && magic == ODOM_SEGMENT_MAGIC;
  const bool begun = unfinished == Unfinished::taken && length >= 0 && magic == 0;
  if (!segment && !begun && !(length == 0 && is_emptied_segment(path, status)))
    throw std::runtime_error(path + ": is " + kind_of(status.st_mode) +
                             ", not a segment of odomd: remove it, or set another [shm] name");
}

void note_owner(int lock, const std::string& path) {
  const std::string pid = std::to_string(getpid()) + '\n';
  if (ftruncate(lock, 0) != 0 ||
      pwrite(lock, pid.data(), pid.size(), 0) != static_cast<ssize_t>(pid.size()))
    fail(path, "record the lock's owner");
}

gid_t group_id(const std::string& name) {
  std::vector<char> buffer(1024);
  group entry{};
  group* found = nullptr;
  while (getgrnam_r(name.c_str(), &entry, buffer.data(), buffer.size(), &found) == ERANGE)
    buffer.resize(2 * buffer.size());
  if (found == nullptr)
    throw std::invalid_argument("[shm] group: no such group: '" + name +
                                "': create it, or name another");
  return found->gr_gid;
}

}  // namespace

void Unmap::operator()(std::uint64_t* words) const noexcept {
  munmap(words, bytes);
}

std::string segment_path(const std::string& name) {
  char* path = nullptr;
  const odom_status status =
      name.find('\0') == std::string::npos ? odomi_path(name.c_str(), &path) : ODOM_INVALID;
  if (status == ODOM_SYSTEM) throw std::bad_alloc();
  if (status != ODOM_OK)
    throw std::invalid_argument("[shm] name: '" + name +
                                "' is neither a POSIX shm name (/odomd) nor the path of a file");
  std::string result(path);
  std::free(path);  // NOLINT(cppcoreguidelines-no-malloc): malloc'ed by C
  return result;
}

FileId id_of(int file) {
  struct stat status {};
  return fstat(file, &status) == 0 ? FileId{status.st_dev, status.st_ino} : FileId{};
}

FileId id_of(const std::string& path) {
  struct stat status {};
  return lstat(path.c_str(), &status) == 0 ? FileId{status.st_dev, status.st_ino} : FileId{};
}

namespace {

FileDescriptor lock_file(const std::string& path) {
  const std::string name = path + ".lock";
  FileDescriptor lock(open(name.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK,
                           S_IRUSR | S_IWUSR));
  if (!lock) fail(name, "open the lock of the segment's writer");
  struct stat status {};
  if (fstat(lock.get(), &status) != 0) fail(name, "inspect the lock");
  if (!S_ISREG(status.st_mode))
    throw std::runtime_error(name + ": is " + kind_of(status.st_mode) +
                             ", not a lock of odomd: remove it, or set another [shm] name");
  if (status.st_uid != geteuid() && status.st_uid != 0)
    throw std::runtime_error(name + ": belongs to user " + std::to_string(status.st_uid) +
                             ": remove it, or set another [shm] name");
  const std::string text = text_of(lock.get());
  if (!is_lock_of_ours(text) || (status.st_mode & 0077U) != 0)
    throw std::runtime_error(
        name + ": is a file, not a lock of odomd: remove it, or set another [shm] name");
  if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) fail(name, "lock it");
    refuse_second_writer(path, pid_in(text));
  }
  if (!(id_of(lock.get()) == id_of(name)))
    throw std::runtime_error(name + ": was removed while it was being locked: start again");
  note_owner(lock.get(), name);
  return lock;
}

FileDescriptor lock_name(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string directory = path.substr(0, std::max<std::size_t>(slash, 1));
  struct stat status {};
  if (stat(directory.c_str(), &status) != 0) fail(path, "inspect its directory");
  // Uses the directory's inode number: in other namespaces the path may name another directory.
  std::string name =
      "odomd-writer:" + std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino) + ":";
  const std::string base = path.substr(slash + 1);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t room = sizeof address.sun_path - 1;
  name += name.size() + base.size() <= room ? base : std::to_string(std::hash<std::string>{}(base));
  name.copy(address.sun_path + 1, room);
  const auto size =
      static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + std::min(name.size(), room));
  const auto* generic = reinterpret_cast<const sockaddr*>(&address);

  FileDescriptor held(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!held) fail(path, "create the socket that locks its name");
  if (bind(held.get(), generic, size) == 0) {
    if (listen(held.get(), SOMAXCONN) != 0) fail(path, "lock its name");
    return held;
  }
  if (errno != EADDRINUSE) fail(path, "lock its name");
  // A user who may not write in this directory must not block us.
  ucred owner{};
  socklen_t owner_size = sizeof owner;
  if (connect(held.get(), generic, size) != 0 ||
      getsockopt(held.get(), SOL_SOCKET, SO_PEERCRED, &owner, &owner_size) != 0 ||
      (owner.uid != 0 && owner.uid != geteuid() && owner.uid != status.st_uid))
    return FileDescriptor();
  refuse_second_writer(path, owner.pid > 0 ? std::to_string(owner.pid) : "");
}

}  // namespace

void refuse_foreign(const std::string& path) {
  require_segment_or_absent(path, Unfinished::refused);
}

SegmentLock lock_segment(const std::string& path) {
  refuse_foreign(path);
  // Locks the name first: a process that cannot get it must not change anything.
  FileDescriptor name = lock_name(path);
  return {lock_file(path), std::move(name)};
}

void renew_lock_file(SegmentLock& lock, const std::string& path) {
  lock.file = lock_file(path);
}

UnnamedSegment create_segment(const std::string& path, std::size_t bytes) {
  // One fixed name, so that the next writer removes the file of a writer that died here.
  std::string temporary = path + ".tmp";
  require_segment_or_absent(temporary, Unfinished::taken);
  if (unlink(temporary.c_str()) != 0 && errno != ENOENT) fail(temporary, "remove it");
  FileDescriptor file(open(temporary.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                           S_IRUSR | S_IWUSR));
  if (!file) fail(temporary, "create the segment");

  // Memory is reserved now: a full tmpfs is an error at start, not a SIGBUS in the beat.
  const int error = posix_fallocate(file.get(), 0, static_cast<off_t>(bytes));
  if (error != 0) {
    unlink(temporary.c_str());
    errno = error;
    fail(temporary, "reserve " + std::to_string(bytes) + " bytes");
  }
  void* memory =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file.get(), 0);
  if (memory == MAP_FAILED) {
    const int map_error = errno;
    unlink(temporary.c_str());
    errno = map_error;
    fail(temporary, "map the segment");
  }
  MappedWords words(static_cast<std::uint64_t*>(memory), Unmap{bytes});
  // Writes every page once, so that it is present and writable before the beat begins.
  for (std::size_t i = 0; i < bytes / sizeof(std::uint64_t); ++i)
    __atomic_store_n(words.get() + i, std::uint64_t{0}, __ATOMIC_RELAXED);
  return {std::move(temporary), std::move(file), std::move(words)};
}

void name_segment(const UnnamedSegment& segment, const std::string& path,
                  const SegmentSettings& settings) {
  try {
    const int fd = segment.file.get();
    if (!settings.group.empty() &&
        fchown(fd, static_cast<uid_t>(-1), group_id(settings.group)) != 0)
      fail(path, "give it to group '" + settings.group + "'");
    if (fchmod(fd, settings.mode) != 0) fail(path, "set its mode");
    if (rename(segment.temporary_path.c_str(), path.c_str()) != 0) fail(path, "take the name");
  } catch (...) {
    unlink(segment.temporary_path.c_str());
    throw;
  }
}

}  // namespace odomd::shm
