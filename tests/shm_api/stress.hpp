// Readers under stress, in threads and in processes of their own (stress_reader.cpp): what they
// read, and what they count, in memory that the test maps as well.
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

/// One reader's. A read is a call that gave a pose; it holds when every word is of the pose's tick.
struct alignas(64) ReaderCounts {
  std::atomic<std::uint64_t> turns{0};       ///< rises as long as the reader is not stuck
  std::atomic<std::uint64_t> reads{0};       ///< that gave a pose
  std::atomic<std::uint64_t> ticks{0};       ///< reads of another tick than the one before
  std::atomic<std::uint64_t> torn{0};        ///< words of two ticks
  std::atomic<std::uint64_t> backwards{0};   ///< an older tick than before, of the same writer
  std::atomic<std::uint64_t> overtaken{0};   ///< attempts that the writer came into
  std::atomic<std::uint64_t> starved{0};     ///< reads that failed: overtaken three times
  std::atomic<std::uint64_t> unexpected{0};  ///< unexpected results
  std::atomic<std::uint64_t> instances{0};   ///< writers met
};

enum class ReaderKind : std::uint8_t {
  copying,   ///< odom_latest, over and over
  in_place,  ///< holds each view until the writer comes round to its slot
  every_way  ///< all calls by turns, sleeping ones too
};

/// Reads until `stop`. `slots`: of the ring.
void read_on(const std::string& path, ReaderKind kind, std::uint64_t slots, ReaderCounts& counts,
             const std::atomic<bool>& stop);

/// The counts of several readers and the word to stop, in a file that processes share.
class SharedCounts {
 public:
  static constexpr std::size_t capacity = 16;
  struct Page {
    std::atomic<bool> stop{false};
    std::array<ReaderCounts, capacity> readers;
  };

  explicit SharedCounts(const std::string& path);  ///< made where it is not there
  ~SharedCounts();
  SharedCounts(const SharedCounts&) = delete;
  SharedCounts& operator=(const SharedCounts&) = delete;
  Page* operator->() const noexcept { return page_; }

 private:
  Page* page_;
};

/// A process, killed at the end where it still runs.
class Process {
 public:
  explicit Process(std::vector<std::string> words);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  /// Waits for its end; its exit status, -1 where a signal ended it.
  int wait();

 private:
  pid_t pid_ = -1;
};

/// A number from the environment, for the longer forms of a test.
[[nodiscard]] std::uint64_t wanted(const char* variable, std::uint64_t usual);

}  // namespace odomd::shm::testing
