// Readers under stress, in threads and in processes: how they read, and their counts, in memory
// that a forked process shares.
#pragma once

#include <sys/mman.h>
#include <sys/wait.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <stdexcept>

#include "tests/gtest.hpp"
#include "tests/process.hpp"
#include "tests/shm_api/segment_fixture.hpp"

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
  copying,   ///< copies pose and details repeatedly
  in_place,  ///< holds each view until the writer reaches its slot again
  every_way  ///< alternates between all calls, including those that sleep
};

inline void count(std::atomic<std::uint64_t>& counter) {
  counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

/// Reads as `kind` says. Each pose must be whole, and, unless writers are killed, not older than
/// the previous one.
class Reader {
 public:
  Reader(odom_client* client, ReaderKind kind, std::uint64_t slots, ReaderCounts& counts)
      : client_(client), kind_(kind), slots_(slots), counts_(counts) {}

  void turn() {
    if (kind_ == ReaderKind::in_place) return read_in_place();
    copy();
    if (kind_ == ReaderKind::every_way) look_and_wait();
  }

 private:
  void copy() {
    odom_pose pose{};
    odom_details details{};
    const odom_status status =
        odom_latest_details(client_, &pose, sizeof pose, &details, sizeof details);
    if (status == ODOM_BUSY) {
      count(counts_.starved);
      if (pose.mode != ODOM_FAULT || pose.x != 0.0) count(counts_.torn);  // a pose in spite of BUSY
    } else if (status <= ODOM_STALE) {
      note(pose.tick);
      if (!is_whole(pose, &details)) count(counts_.torn);
    } else if (status != ODOM_NO_POSE || kind_ == ReaderKind::copying) {
      count(counts_.unexpected);
    }
  }

  // Each attempt is counted. Half-way through, the reader waits until its slot is the next to be
  // written, so that the writer overwrites the slot during the other half.
  void read_in_place() {
    odom_view view{};
    if (odom_begin(client_, &view) > ODOM_STALE) return count(counts_.unexpected);
    std::array<std::uint64_t, ODOM_POSE_WORDS + ODOM_DETAILS_WORDS> words{};
    std::size_t i = 0;
    for (; i < words.size() / 2; ++i) words[i] = odom_view_word(&view, i + 1);
    odom_view newest = view;
    for (int attempt = 0; attempt < 1000; ++attempt) {
      if (newest.sequence >= view.sequence + 2 * (slots_ - 1)) break;
      if (odom_begin(client_, &newest) > ODOM_STALE) return count(counts_.unexpected);
    }
    for (; i < words.size(); ++i) words[i] = odom_view_word(&view, i + 1);
    if (odom_validate(&view) == 0) return count(counts_.overtaken);
    note(words[0]);
    for (i = 2; i < words.size(); ++i)
      if (words[i] != pattern(words[0], i)) return count(counts_.torn);
  }

  void look_and_wait() {
    odom_view view{};
    if (odom_begin(client_, &view) <= ODOM_STALE) {
      const std::uint64_t tick = odom_view_word(&view, ODOM_WORD_TICK);
      constexpr std::size_t last_index = ODOM_POSE_WORDS + ODOM_DETAILS_WORDS - 1;
      const std::uint64_t last = odom_view_word(&view, ODOM_WORD_TICK + last_index);
      if (odom_validate(&view) == 0)
        count(counts_.overtaken);
      else if (last != pattern(tick, last_index))
        count(counts_.torn);
    }
    const odom_status status = odom_wait(client_, &waited_, sizeof waited_, 100'000);
    if (status == ODOM_OK && !is_whole(waited_)) count(counts_.torn);
    odom_info info{};
    if (odom_get_info(client_, &info, sizeof info) > ODOM_STALE) return count(counts_.unexpected);
    if (info.instance_id != instance_) count(counts_.instances);
    instance_ = info.instance_id;
  }

  void note(std::uint64_t tick) {
    count(counts_.reads);
    if (tick != last_) count(counts_.ticks);
    if (tick < last_ && kind_ != ReaderKind::every_way) count(counts_.backwards);
    last_ = tick;
  }

  odom_client* client_;
  ReaderKind kind_;
  std::uint64_t slots_;
  ReaderCounts& counts_;
  odom_pose waited_{};
  std::uint64_t last_ = 0;
  std::uint64_t instance_ = 0;
};

/// Reads until `stop`; the ring has `slots` slots.
inline void read_on(const std::string& path, ReaderKind kind, std::uint64_t slots,
                    ReaderCounts& counts, const std::atomic<bool>& stop) {
  const ClientPointer client = open_client(path);
  for (Reader reader(client.get(), kind, slots, counts); !stop.load(std::memory_order_relaxed);) {
    reader.turn();
    count(counts.turns);
  }
}

/// The counts of several readers and the flag that stops them, shared with forked processes.
class SharedCounts {
 public:
  static constexpr std::size_t capacity = 4;
  struct Page {
    std::atomic<bool> stop{false};
    std::array<ReaderCounts, capacity> readers;
  };

  SharedCounts() {
    void* memory =
        mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("mmap");
    page_ = static_cast<Page*>(memory);  // zero bytes are valid counts
  }
  ~SharedCounts() { munmap(page_, sizeof(Page)); }
  SharedCounts(const SharedCounts&) = delete;
  SharedCounts& operator=(const SharedCounts&) = delete;
  Page* operator->() const noexcept { return page_; }

 private:
  Page* page_;
};

/// A number from the environment, which makes a test longer; otherwise `usual`.
inline std::uint64_t wanted(const char* variable, std::uint64_t usual) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : usual;
}

}  // namespace odomd::shm::testing
