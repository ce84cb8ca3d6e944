#include "shm_api/segment_file.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <vector>

#include "shm_api/libodom/attach.h"
#include "shm_api/segment.h"

namespace odomd::shm {
namespace {

// A path that cannot be is the user's error; all else is the machine's.
[[noreturn]] void fail(const std::string& path, const std::string& what) {
  const int error = errno;
  if (error == ENOENT || error == ENOTDIR)
    throw std::invalid_argument(path + ": no such directory: create it, or set [shm] name");
  if (error == ENAMETOOLONG) throw std::invalid_argument(path + ": too long for a [shm] name");
  // Directories like /dev/shm are everyone's; what lies there may be another user's.
  if (error == EACCES || error == EPERM)
    throw std::system_error(error, std::generic_category(),
                            path + ": cannot " + what +
                                ": if it is another user's, remove it or set another [shm] name");
  throw std::system_error(error, std::generic_category(), path + ": cannot " + what);
}

// A lock holds no more than its owner's pid.
constexpr std::size_t longest_owner = 24;

std::string owner_of_lock(int lock) {
  std::array<char, longest_owner> text{};
  const ssize_t length = pread(lock, text.data(), text.size(), 0);
  const std::string_view digits(text.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  const std::string pid(digits.substr(0, digits.find('\n')));
  return pid.empty() ? "another process" : "process " + pid;
}

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a directory";
  if (S_ISLNK(mode)) return "a link";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return S_ISREG(mode) ? "a file" : "a device";
}

enum class Unfinished { refused, taken };

/// Whoever publishes as root could replace anything: only what a writer has left is replaced. Of an
/// unfinished segment the first word is still zero.
void refuse_what_is_no_segment(const std::string& path, Unfinished unfinished) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) return;
    fail(path, "look at it");
  }
  std::uint64_t magic = 0;
  ssize_t length = -1;
  if (S_ISREG(status.st_mode)) {
    const FileDescriptor file(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
    if (file.get() < 0) fail(path, "read it");
    length = pread(file.get(), &magic, sizeof magic, 0);
    if (length < 0) fail(path, "read it");
  }
  const bool segment = length == sizeof magic && magic == ODOM_SEGMENT_MAGIC;
  const bool begun = unfinished == Unfinished::taken && length >= 0 && magic == 0;
  if (!segment && !begun)
    throw std::invalid_argument(path + ": is " + kind_of(status.st_mode) +
                                ", no segment of odomd, and stays: remove it, or set another "
                                "[shm] name");
}

void note_owner(int lock, const std::string& path) {
  const std::string pid = std::to_string(getpid()) + '\n';
  if (ftruncate(lock, 0) != 0 ||
      pwrite(lock, pid.data(), pid.size(), 0) != static_cast<ssize_t>(pid.size()))
    fail(path, "note the owner of the lock");
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

FileDescriptor::~FileDescriptor() {
  if (fd_ >= 0) close(fd_);
}

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

FileDescriptor lock_segment(const std::string& path) {
  refuse_what_is_no_segment(path, Unfinished::refused);
  const std::string name = path + ".lock";
  FileDescriptor lock(open(name.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK,
                           S_IRUSR | S_IWUSR));
  if (lock.get() < 0) fail(name, "open the lock of the segment's writer");
  struct stat status {};
  if (fstat(lock.get(), &status) != 0) fail(name, "look at the lock");
  if (!S_ISREG(status.st_mode) || (status.st_uid != geteuid() && status.st_uid != 0))
    throw std::invalid_argument(name + ": belongs to user " + std::to_string(status.st_uid) +
                                ": remove it, or set another [shm] name");
  if (status.st_size > static_cast<off_t>(longest_owner))
    throw std::invalid_argument(name +
                                ": is a file, no lock of odomd, and stays: remove it, or set "
                                "another [shm] name");
  if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) fail(name, "lock it");
    throw std::invalid_argument(path + ": " + owner_of_lock(lock.get()) +
                                " publishes there already: stop it, or set another [shm] name");
  }
  note_owner(lock.get(), name);
  return lock;
}

UnnamedSegment create_segment(const std::string& path, std::size_t bytes) {
  // One fixed name: what a writer that died here has left is removed by the next.
  std::string temporary = path + ".tmp";
  refuse_what_is_no_segment(temporary, Unfinished::taken);
  if (unlink(temporary.c_str()) != 0 && errno != ENOENT) fail(temporary, "remove it");
  FileDescriptor file(open(temporary.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                           S_IRUSR | S_IWUSR));
  if (file.get() < 0) fail(temporary, "create the segment");

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
  // Written once, so that every page is there, and writable, before the beat begins.
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
