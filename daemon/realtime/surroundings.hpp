// The conditions that the pipeline cannot know: machine, links and clocks. Pure logic on the
// observations of the beat in a tick.
#pragma once

#include <cstdint>

#include <odom/types.h>

namespace odomd::daemon {

/// The observations of one tick.
struct Sighting {
  std::int64_t now_ns = 0;
  bool link_down = false;             ///< a bus is down or gone
  bool input_ended = false;           ///< a log or a pipe has ended
  bool carried_over = false;          ///< a drain left frames for the next tick
  bool clock_stepped = false;         ///< since the previous tick
  bool suspended = false;             ///< since the previous tick
  std::uint64_t frames_lost = 0;      ///< dropped by the kernel since start, all buses
  std::uint64_t cameras_refused = 0;  ///< camera connections refused since start
};

class Surroundings {
 public:
  static constexpr std::int64_t memory_ns = 1'000'000'000;    ///< how long an incident is reported
  static constexpr std::int64_t restart_ns = 10'000'000'000;  ///< how long a restart is reported
  static constexpr std::int64_t refusal_ns = 10'000'000'000;  ///< how long a refusal is reported

  /// `standing` are conditions that hold from start to end.
  explicit Surroundings(std::uint32_t standing) : standing_(standing) {}

  void restarted(std::int64_t now_ns) noexcept { restarted_.happened(now_ns); }

  /// The ODOM_COND_ bits for this tick.
  [[nodiscard]] std::uint32_t conditions(const Sighting& seen) noexcept {
    if (seen.frames_lost != frames_lost_) lost_.happened(seen.now_ns);
    if (seen.clock_stepped) stepped_.happened(seen.now_ns);
    if (seen.suspended) suspended_.happened(seen.now_ns);
    if (seen.cameras_refused != cameras_refused_) refused_.happened(seen.now_ns);
    frames_lost_ = seen.frames_lost;
    cameras_refused_ = seen.cameras_refused;

    std::uint32_t bits = standing_;
    const auto add = [&](bool holds, std::uint32_t bit) { bits |= holds ? bit : 0U; };
    add(seen.link_down, ODOM_COND_BUS_DOWN);
    add(seen.input_ended, ODOM_COND_INPUT_ENDED);
    add(seen.carried_over, ODOM_COND_CARRIED_OVER);
    add(lost_.within(memory_ns, seen.now_ns), ODOM_COND_FRAMES_LOST);
    add(stepped_.within(memory_ns, seen.now_ns), ODOM_COND_CLOCK_STEPPED);
    add(suspended_.within(memory_ns, seen.now_ns), ODOM_COND_SUSPENDED);
    add(restarted_.within(restart_ns, seen.now_ns), ODOM_COND_RESTARTED);
    add(refused_.within(refusal_ns, seen.now_ns), ODOM_COND_CAMERA_REFUSED);
    return bits;
  }

 private:
  struct Incident {
    bool ever = false;
    std::int64_t last_ns = 0;
    void happened(std::int64_t now_ns) noexcept {
      ever = true;
      last_ns = now_ns;
    }
    [[nodiscard]] bool within(std::int64_t span_ns, std::int64_t now_ns) const noexcept {
      return ever && now_ns - last_ns < span_ns;
    }
  };

  std::uint32_t standing_;
  std::uint64_t frames_lost_ = 0;
  std::uint64_t cameras_refused_ = 0;
  Incident lost_;
  Incident stepped_;
  Incident suspended_;
  Incident restarted_;
  Incident refused_;
};

}  // namespace odomd::daemon
