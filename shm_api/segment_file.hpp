// The file behind a segment: locked against a second writer, filled under a temporary name, and
// renamed into place, so that a reader finds it whole or not at all. Start-up only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

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
  FileDescriptor& operator=(FileDescriptor&&) = delete;
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

/// Takes the lock of the one writer, `path`.lock, which stays behind when it is released. Throws
/// std::invalid_argument when another writer lives, naming its pid, or when something that is no
/// segment stands at `path`.
[[nodiscard]] FileDescriptor lock_segment(const std::string& path);

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
