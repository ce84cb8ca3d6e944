// Shared by the fuzzers: a check that works in every build, and a file in memory.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace odomd::fuzz {

inline void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "fuzz: broken: %s\n", what);
  std::abort();
}

/// An error text must be one line of limited length.
inline void require_one_line(std::string_view text) {
  require(!text.empty(), "the error has a text");
  require(text.find('\n') == std::string_view::npos, "the error is one line");
  require(text.size() < 4096, "the error is short");
}

/// Reads values from the beginning of the fuzzer's input.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}
  [[nodiscard]] bool empty() const { return rest_.empty(); }

  /// Bytes beyond the end are zero.
  template <typename Value>
  Value take() {
    Value value{};
    const std::size_t size = std::min(sizeof value, rest_.size());
    std::memcpy(&value, rest_.data(), size);
    rest_ = rest_.subspan(size);
    return value;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

class MemoryFile {
 public:
  MemoryFile(const std::uint8_t* data, std::size_t size)
      : descriptor_(::memfd_create("fuzz", MFD_CLOEXEC)) {
    require(descriptor_ >= 0, "memfd_create");
    for (std::size_t done = 0; done < size;) {
      const ssize_t written = ::write(descriptor_, data + done, size - done);
      require(written > 0, "write to a memfd");
      done += static_cast<std::size_t>(written);
    }
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { ::close(descriptor_); }

  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

/// Lets `read` read the input as a file, by its path. It may fail with an error of one line.
template <typename Error = std::invalid_argument, typename Read>
int read_file(const std::uint8_t* data, std::size_t size, const Read& read) {
  const MemoryFile file(data, size);
  try {
    read(file.path());
  } catch (const Error& error) {
    require_one_line(error.what());
  }
  return 0;
}

}  // namespace odomd::fuzz
