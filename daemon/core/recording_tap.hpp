// What the beat takes in and what it publishes, for a recorder: the frames and camera poses as the
// pipeline got them, and a mark for each tick. Through rings of a fixed size from the beat to
// housekeeping; while nobody records, a tick costs one load.
//
// A recording begins behind a tick with a copy of the pipeline's state, so that whoever replays the
// inputs from there gets the bits that were published, in whatever part of a drive it began. It has
// no holes: where a ring is full it ends, with the last tick that is in it whole.
//
// The rings take 5 MB, locked: they come with the first recording. A daemon that nobody records
// starts without them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/spsc_ring.hpp"
#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/frame.hpp"
#include "daemon/core/pipeline.hpp"
#include "daemon/core/record.hpp"
#include "estimator/common/measurement.hpp"

namespace odomd::daemon {

/// One published tick, and how much of the rings belongs to it.
struct TickMark {
  TickRecord record;                    ///< as the pipeline made it
  std::int64_t woke_ns = 0;             ///< time of the drain, CLOCK_MONOTONIC
  std::int64_t realtime_offset_ns = 0;  ///< CLOCK_REALTIME - CLOCK_MONOTONIC, as measured
  std::uint32_t conditions = 0;         ///< ODOM_COND_ bits from outside the pipeline
  std::uint32_t frames = 0;             ///< taken in by this tick, in their order
  std::uint32_t cameras = 0;            ///< camera poses, likewise
};

/// What a pipeline goes on from, behind one tick.
struct Checkpoint {
  PipelineState state;
  std::vector<can::ProtectionState> protections;
};

class RecordingTap {
 public:
  /// Room for the housekeeping thread, or whoever writes the files, to be late: 10 s of ticks at
  /// 5 ms, 4 s of frames on a full bus.
  static constexpr std::size_t max_frames = 32768;
  static constexpr std::size_t max_cameras = 4096;
  static constexpr std::size_t max_ticks = 2048;

  enum class State : std::uint8_t {
    idle,    ///< nobody records
    wanted,  ///< housekeeping's wish: begin behind the next tick
    running,
    full,     ///< a ring was: the recording ends with the marks that are there
    unwanted  ///< housekeeping's wish: end
  };

  /// Start-up: allocates.
  explicit RecordingTap(const Pipeline& pipeline)
      : checkpoint_{pipeline.state(),
                    {pipeline.protections().begin(), pipeline.protections().end()}} {}

  // The beat's, real-time safe
  // ---------------------------------------------------------------------

  void take(const can::Frame& frame) noexcept {
    if (!taking_) return;
    taking_ = rings_->frames.push(frame);
    ++mark_.frames;
  }
  void take(const estimator::CameraPose& pose) noexcept {
    if (!taking_) return;
    taking_ = rings_->cameras.push(pose);
    ++mark_.cameras;
  }

  /// What the beat saw around a tick.
  struct Around {
    std::int64_t woke_ns = 0;
    std::int64_t realtime_offset_ns = 0;
    std::uint32_t conditions = 0;
  };
  /// Ends the tick that made `record`; `pipeline` is as it left it. Where a recording begins this
  /// copies its state, some 400 kB.
  void tick_done(const TickRecord& record, const Around& around, const Pipeline& pipeline) noexcept;

  // Housekeeping's
  // ---------------------------------------------------------------------------------

  [[nodiscard]] State state() const noexcept { return state_.load(std::memory_order_acquire); }

  /// Only when idle: the beat goes to `running` behind its next tick. The first mark is that
  /// tick's, the checkpoint the state behind it, so no inputs belong to it. The first time it
  /// allocates.
  void begin();
  /// The beat goes back to `idle` behind its next tick.
  void end() noexcept;
  /// Once running, until end().
  [[nodiscard]] const Checkpoint& checkpoint() const noexcept { return checkpoint_; }

  /// The oldest mark, or null; its inputs are in the rings by then. Take these out, then the mark.
  [[nodiscard]] const TickMark* mark() noexcept { return rings_ ? rings_->marks.front() : nullptr; }
  void pop_mark() noexcept { rings_->marks.pop(); }
  [[nodiscard]] can::Frame take_frame() noexcept { return taken(rings_->frames); }
  [[nodiscard]] estimator::CameraPose take_camera() noexcept { return taken(rings_->cameras); }

 private:
  template <typename T, std::size_t capacity>
  static T taken(SpscRing<T, capacity>& ring) noexcept {
    const T item = *ring.front();
    ring.pop();
    return item;
  }

  std::atomic<State> state_{State::idle};
  bool taking_ = false;  // the beat's: running, and everything of this tick has found room
  TickMark mark_;        // the beat's: of the tick in hand
  Checkpoint checkpoint_;
  struct Rings {
    SpscRing<can::Frame, max_frames> frames;
    SpscRing<estimator::CameraPose, max_cameras> cameras;
    SpscRing<TickMark, max_ticks> marks;
  };
  std::unique_ptr<Rings> rings_;  // the beat looks at them from `wanted` on
};

}  // namespace odomd::daemon
