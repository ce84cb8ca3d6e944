// The writer of the segment: one thread publishes one pose per tick, wait-free.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include <odom/types.h>

namespace odomd::shm {

struct SegmentSettings {
  std::string name = "/odomd";  ///< POSIX shm name, or a path
  std::uint64_t slots = 1024;   ///< history, a power of two
  std::uint32_t mode = 0644;    ///< of the file: 0600, 0640 or 0644
  std::string group{};          ///< of the file; empty: the group of the process
};

/// The last pose of a predecessor, for a restarted daemon.
struct Inheritance {
  odom_pose pose{};
  odom_details details{};
  odom_info info{};
};

/// Another writer publishes under the name.
class Displaced : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The right to write under a name (segment_file.hpp: SegmentLock). The segment of a predecessor
/// stays unchanged until a Writer is created: a failed start loses nothing.
class Claim {
 public:
  /// Start-up only: throws std::invalid_argument for settings that are impossible on any machine,
  /// Displaced when another writer is alive, std::runtime_error when a file is in the way or the
  /// machine refuses.
  explicit Claim(const SegmentSettings& settings);
  ~Claim();
  Claim(Claim&& other) noexcept;
  Claim& operator=(Claim&&) = delete;
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

  /// The last pose of the segment with this name, of any age.
  [[nodiscard]] const std::optional<Inheritance>& predecessor() const noexcept;
  /// Whether the last pose exists but is unusable: damaged, truncated, or of another layout.
  [[nodiscard]] bool predecessor_is_damaged() const noexcept;

 private:
  friend class Writer;
  struct State;
  std::unique_ptr<State> state_;
};

/// The result of a check of the segment's name.
enum class Upkeep : std::uint8_t {
  unchanged,     ///< the segment has its name
  lock_renewed,  ///< the segment has its name, but the lock file had to be recreated
  recreated      ///< its name was gone: a new segment serves from the next tick
};

/// Creates the segment under a temporary name and renames it into place, so that readers find a
/// complete segment or none.
class Writer {
 public:
  /// Start-up only: throws like Claim(). `info` fills the header, except for instance_id,
  /// writer_pid, writer_start_ns, slots and ABI, which are set here.
  Writer(Claim claim, const odom_info& info);
  /// Also claims the name.
  Writer(const SegmentSettings& settings, const odom_info& info) : Writer(Claim(settings), info) {}
  ~Writer();  ///< leaves the last poses in place for clients and for a successor
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  Writer(Writer&&) = delete;
  Writer& operator=(Writer&&) = delete;

  /// The last pose of the previous segment with this name, of any age.
  [[nodiscard]] const std::optional<Inheritance>& predecessor() const noexcept;

  // Real-time safe, from the beat's thread alone -------------------------------------------------
  /// False: the tick does not increase, and nothing was published.
  bool publish(const odom_pose& pose, const odom_details& details) noexcept;
  void set_first_tick(std::int64_t first_tick_ns) noexcept;
  void set_heartbeat(std::int64_t now_ns) noexcept;
  void count_wakeup(std::int64_t latency_ns) noexcept;
  void count_execution(std::int64_t execution_ns) noexcept;
  void count_missed(std::uint64_t cycles) noexcept;
  void count_overrun(std::int64_t now_ns, std::int64_t execution_ns) noexcept;
  void count_carried_over() noexcept;
  void set_realtime_offset(std::int64_t offset_ns) noexcept;
  void set_log_offset(std::int64_t offset_ns) noexcept;

  // Housekeeping's -------------------------------------------------------------------------------
  /// Checks that the segment still has its name; recreates it if somebody removed it. The new
  /// segment has another instance id, and readers switch to it as to a successor's. Not real-time.
  /// Throws Displaced when another writer has the name, std::exception when it cannot be created:
  /// poses then still go to the old segment, which only its current readers see.
  Upkeep maintain();
  [[nodiscard]] odom_beat beat() const noexcept;
  /// As written at start: later changes of offsets and first tick are in the segment only.
  [[nodiscard]] odom_info info() const noexcept;

  // The relay's ----------------------------------------------------------------------------------
  /// Wakes every waiting client: never call it from the beat.
  void wake_clients() noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace odomd::shm
