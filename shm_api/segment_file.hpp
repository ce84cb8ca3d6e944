// The file behind a segment: locked against a second writer, filled under a temporary name, and
// renamed into place, so that a reader finds it whole or not at all. Start-up only.
#pragma once

#include <sys/types.h>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "shm_api/writer.hpp"

namespace odomd::shm {

/// An open file descriptor with one owner.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) noexcept : fd_(fd) {}
  ~FileDescriptor();
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  [[nodiscard]] int get() const noexcept { return fd_; }

 private:
  int fd_;
};

/// The words of a segment, mapped for writing.
struct Unmap {
  std::size_t bytes = 0;
  void operator()(std::uint64_t* words) const noexcept;
};
using MappedWords = std::unique_ptr<std::uint64_t, Unmap>;

/// Where a segment of this name lies. Throws std::invalid_argument for what is no name.
[[nodiscard]] std::string segment_path(const std::string& name);

/// Which file it is, whatever it is called; zeros: none.
struct FileId {
  dev_t device = 0;
  ino_t inode = 0;
  friend bool operator==(const FileId&, const FileId&) = default;
};
[[nodiscard]] FileId id_of(int file);
[[nodiscard]] FileId id_of(const std::string& path);

/// What keeps a second writer out, both for as long as the process lives: `path`.lock with flock,
/// whoever shares the file system; and an abstract socket named after the directory, which nobody
/// can remove.
struct SegmentLock {
  FileDescriptor file;
  FileDescriptor name;  ///< none where a stranger has taken the socket's name
};

/// Throws std::runtime_error where something stands at `path` that no writer has left.
void refuse_foreign(const std::string& path);

/// Takes the lock of the one writer; its file stays behind when it is released. Throws Displaced
/// when another writer lives, naming its pid, else as refuse_foreign does.
[[nodiscard]] SegmentLock lock_segment(const std::string& path);

/// Takes the file of a lock that is held, after it was removed. Throws as lock_segment does.
void renew_lock_file(SegmentLock& lock, const std::string& path);

/// A file that has no name yet that readers would look for.
struct UnnamedSegment {
  std::string temporary_path;
  FileDescriptor file;
  MappedWords words;
};

/// Creates, sizes and maps it, every page present, all words zero. The lock must be held.
[[nodiscard]] UnnamedSegment create_segment(const std::string& path, std::size_t bytes);

/// Gives it its group, mode and name.
void name_segment(const UnnamedSegment& segment, const std::string& path,
                  const SegmentSettings& settings);

}  // namespace odomd::shm
