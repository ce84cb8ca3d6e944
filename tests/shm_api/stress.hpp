// Readers under stress, as threads and as processes (stress_reader.cpp): how they read, and their
// counts, in memory that the test maps as well.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

#include <odom/odom.h>

namespace odomd::shm::testing {

/// Counts of one reader. A read gives a pose; it is whole if all words belong to the pose's tick.
struct alignas(64) ReaderCounts {
  std::atomic<std::uint64_t> turns{0};      ///< rises unless the reader is stuck
  std::atomic<std::uint64_t> reads{0};      ///< calls that gave a pose
  std::atomic<std::uint64_t> ticks{0};      ///< reads of another tick than the previous read
  std::atomic<std::uint64_t> torn{0};       ///< reads with words of two ticks
  std::atomic<std::uint64_t> backwards{0};  ///< reads of an older tick of the same writer
  std::atomic<std::uint64_t> overtaken{0};  ///< attempts during which the writer reached the slot
  std::atomic<std::uint64_t> starved{0};    ///< reads that failed: overtaken three times
  std::atomic<std::uint64_t> unexpected{0};
  std::atomic<std::uint64_t> instances{0};  ///< number of writers seen
};

enum class ReaderKind : std::uint8_t {
  copying,   ///< calls odom_latest repeatedly
  in_place,  ///< holds each view until the writer reaches its slot again
  every_way  ///< alternates between all calls, including those that sleep
};

/// Reads until `stop`; the ring has `slots` slots.
void read_on(const std::string& path, ReaderKind kind, std::uint64_t slots, ReaderCounts& counts,
             const std::atomic<bool>& stop);

/// The counts of several readers and the flag that stops them, in a file that processes share.
class SharedCounts {
 public:
  static constexpr std::size_t capacity = 16;
  struct Page {
    std::atomic<bool> stop{false};
    std::array<ReaderCounts, capacity> readers;
  };

  explicit SharedCounts(const std::string& path);  ///< creates the file if it does not exist
  ~SharedCounts();
  SharedCounts(const SharedCounts&) = delete;
  SharedCounts& operator=(const SharedCounts&) = delete;
  Page* operator->() const noexcept { return page_; }

 private:
  Page* page_;
};

/// A process, killed at the end if it is still running.
class Process {
 public:
  explicit Process(std::vector<std::string> words);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  /// Waits for its end; returns the exit status, -1 if a signal ended it.
  int wait();

 private:
  pid_t pid_ = -1;
};

/// A number from the environment, which makes a test longer; otherwise `usual`.
[[nodiscard]] std::uint64_t wanted(const char* variable, std::uint64_t usual);

}  // namespace odomd::shm::testing
