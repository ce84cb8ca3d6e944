// The file of a segment: locked against a second writer, filled under a temporary name, and renamed
// into place, so that a reader finds a complete segment or none. Start-up only.
#pragma once

#include <sys/types.h>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "base/file_descriptor.hpp"
#include "shm_api/writer.hpp"

namespace odomd::shm {

/// Unmaps the words of a segment, which are mapped for writing.
struct Unmap {
  std::size_t bytes = 0;
  void operator()(std::uint64_t* words) const noexcept;
};
using MappedWords = std::unique_ptr<std::uint64_t, Unmap>;

/// The path of the segment of this name. Throws std::invalid_argument for an invalid name.
[[nodiscard]] std::string segment_path(const std::string& name);

/// Identifies a file independently of its name; zeros: none.
struct FileId {
  dev_t device = 0;
  ino_t inode = 0;
  friend bool operator==(const FileId&, const FileId&) = default;
};
[[nodiscard]] FileId id_of(int file);
[[nodiscard]] FileId id_of(const std::string& path);

/// The locks against a second writer, held as long as the process lives: `path`.lock with flock,
/// for all that share the file system; and an abstract socket named after the directory, which
/// nobody can remove.
struct SegmentLock {
  FileDescriptor file;
  FileDescriptor name;  ///< empty when another user has taken the name of the socket
};

/// Throws std::runtime_error when there is a file at `path` that is not from a writer.
void refuse_foreign(const std::string& path);

/// Takes the writer's lock; its file remains after the release. Throws Displaced with the pid when
/// another writer is alive; otherwise throws as refuse_foreign does.
[[nodiscard]] SegmentLock lock_segment(const std::string& path);

/// Recreates the file of a lock that is held, after the file was removed. Throws as lock_segment
/// does.
void renew_lock_file(SegmentLock& lock, const std::string& path);

/// A file that readers cannot find yet.
struct UnnamedSegment {
  std::string temporary_path;
  FileDescriptor file;
  MappedWords words;
};

/// Creates, sizes and maps a segment; all pages are present, all words zero. The lock must be held.
[[nodiscard]] UnnamedSegment create_segment(const std::string& path, std::size_t bytes);

/// Gives the segment its group, mode and name.
void name_segment(const UnnamedSegment& segment, const std::string& path,
                  const SegmentSettings& settings);

}  // namespace odomd::shm
