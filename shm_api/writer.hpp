// The writer's end of the segment: one thread publishes a pose a tick, wait-free.
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
  std::string group{};          ///< of the file; empty: the process's
};

/// A predecessor's last word, for a restarted daemon.
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

/// The right to write under a name (segment_file.hpp: SegmentLock). What a predecessor has
/// published there stays untouched until a Writer is made: a start that fails loses nothing.
class Claim {
 public:
  /// Start-up only: throws std::invalid_argument for settings that no machine could use, Displaced
  /// when another writer is alive, std::runtime_error when something is in the way or the machine
  /// refuses.
  explicit Claim(const SegmentSettings& settings);
  ~Claim();
  Claim(Claim&& other) noexcept;
  Claim& operator=(Claim&&) = delete;
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

  /// The last pose of the segment that stands under the name, whatever its age.
  [[nodiscard]] const std::optional<Inheritance>& predecessor() const noexcept;
  /// Whether there is one that is not given: damaged, cut short, or of another layout.
  [[nodiscard]] bool predecessor_is_damaged() const noexcept;

 private:
  friend class Writer;
  struct State;
  std::unique_ptr<State> state_;
};

/// What a look at the segment's name found.
enum class Upkeep : std::uint8_t {
  stands,        ///< the segment has its name
  lock_renewed,  ///< it has, but the file of its lock was gone
  made_again     ///< it had not: there is a new one now, which the next tick goes to
};

/// Creates the segment under a temporary name and renames it into place, so that readers find it
/// whole or not at all.
class Writer {
 public:
  /// Start-up only: throws as a Claim does. `info` fills the header; its instance_id, writer_pid,
  /// writer_start_ns, slots and ABI are set here.
  Writer(Claim claim, const odom_info& info);
  /// Claims the name as well.
  Writer(const SegmentSettings& settings, const odom_info& info) : Writer(Claim(settings), info) {}
  ~Writer();  ///< leaves the last poses in place for clients and for a successor
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  Writer(Writer&&) = delete;
  Writer& operator=(Writer&&) = delete;

  /// The last pose of the segment that stood under the name before, whatever its age.
  [[nodiscard]] const std::optional<Inheritance>& predecessor() const noexcept;

  // Real-time safe, from the beat's thread alone -------------------------------------------------
  /// False: the tick does not rise, and nothing was published.
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
  /// Whether the segment still stands under its name; makes it again where somebody took it away.
  /// The new one has another instance id, and readers go over to it as to a successor's. Not
  /// real-time. Throws Displaced when another writer has the name by now, std::exception when it
  /// cannot be made: poses then go on into the old one, which only its readers see.
  Upkeep look_after();
  [[nodiscard]] odom_beat beat() const noexcept;
  /// As written at start: offsets and the first tick that were set since are in the segment alone.
  [[nodiscard]] odom_info info() const noexcept;

  // The relay's ----------------------------------------------------------------------------------
  /// Wakes every client that waits: never the beat's call.
  void wake_clients() noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace odomd::shm
