// The beat: one thread that drains the buses and the cameras, steps the filter and publishes the
// pose, once per period.
//
// In a tick there is no heap, lock, exception, formatting or page fault, and every drain has a
// maximum. The system calls are recvmmsg on the buses, recvmsg on the camera connections, one futex
// wake of the relay, and the sleep.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>

#include "base/counter.hpp"
#include "base/wall_clock.hpp"
#include "can_protocol/sources/frame_source.hpp"
#include "can_protocol/sources/log_clock.hpp"
#include "daemon/core/record.hpp"
#include "daemon/journal/event.hpp"
#include "daemon/realtime/relay.hpp"
#include "daemon/realtime/surroundings.hpp"
#include "daemon/realtime/tick_grid.hpp"
#include "daemon/sockets/camera_server.hpp"
#include "shm_api/writer.hpp"

namespace odomd::daemon {

class Pipeline;
class RecordingTap;

/// The parts that the beat uses. All of them outlive it.
struct BeatParts {
  std::span<const std::unique_ptr<can::FrameSource>> sources;
  const can::LogClock& log_clock;
  CameraServer& cameras;
  Pipeline& pipeline;
  shm::Writer& writer;
  Relay& relay;
  EventRing& events;
  RecordingTap& tap;
};

/// Counters of the beat. Any thread may read them.
struct BeatCounters {
  Counter ticks;            ///< liveness counter for the watchdog
  Counter camera_messages;  ///< malformed ones included
  Counter camera_malformed;
  Counter clock_steps;
  Counter suspends;
  Counter realtime_offset_ns;  ///< bit pattern of the signed offset
};

class Beat {
 public:
  Beat(const BeatParts& parts, std::int64_t period_ns);

  /// The loop; runs in the calling thread. Returns at the tick after stop().
  void run(const Surroundings& surroundings) noexcept;
  void stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  [[nodiscard]] const BeatCounters& counters() const noexcept { return counters_; }

 private:
  void read_clock(std::int64_t now_ns) noexcept;
  void drain_buses(std::int64_t tick_ns, std::int64_t now_ns) noexcept;
  void drain_cameras(std::int64_t now_ns) noexcept;
  void publish(const TickRecord& record, std::int64_t wakeup_latency_ns) noexcept;
  [[nodiscard]] std::uint64_t account(const NextTick& due, std::int64_t wakeup_latency_ns,
                                      std::int64_t woke_ns) noexcept;

  BeatParts parts_;
  TickGrid grid_;
  Surroundings surroundings_{0};
  Sighting seen_;
  WallClock wall_clock_;
  std::int64_t execution_ns_ = 0;  // of the previous tick
  std::uint64_t skipped_ = 0;      // cycles after the previous tick, not counted yet
  std::uint32_t reset_count_ = 0;
  std::atomic<bool> stop_{false};
  BeatCounters counters_;
  std::array<can::Frame, can::max_frames_per_drain> frames_{};
  std::array<estimator::CameraPose, CameraServer::max_poses> poses_{};
};

}  // namespace odomd::daemon
