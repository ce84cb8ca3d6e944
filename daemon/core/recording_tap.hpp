// Passes the inputs and outputs of the beat to a recorder: the frames and camera poses that the
// pipeline got, and a mark for each tick. Rings of a fixed size carry them from the beat to
// housekeeping; without a recorder a tick costs one load.
//
// A recording begins after a tick with a copy of the pipeline's state, so a replay from there gives
// exactly the published bits, wherever in a drive it begins. A recording has no gaps: when a ring
// is full, the recording ends with the last complete tick.
//
// The rings take 5 MB of locked memory and are allocated for the first recording only.
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

/// One published tick, and the number of its inputs in the rings.
struct TickMark {
  TickRecord record;                    ///< as the pipeline made it
  std::int64_t woke_ns = 0;             ///< time of the drain, CLOCK_MONOTONIC
  std::int64_t realtime_offset_ns = 0;  ///< CLOCK_REALTIME - CLOCK_MONOTONIC, as measured
  std::uint32_t conditions = 0;         ///< ODOM_COND_ bits from outside the pipeline
  std::uint32_t frames = 0;             ///< number of this tick's frames, in order
  std::uint32_t cameras = 0;            ///< number of this tick's camera poses, in order
};

/// The state from which a pipeline can continue after a tick.
struct Checkpoint {
  PipelineState state;
  std::vector<can::ProtectionState> protections;
};

class RecordingTap {
 public:
  /// The margin for a late housekeeping thread or a slow writer of the files: 10 s of ticks at
  /// 5 ms, 4 s of frames on a full bus.
  static constexpr std::size_t max_frames = 32768;
  static constexpr std::size_t max_cameras = 4096;
  static constexpr std::size_t max_ticks = 2048;

  enum class State : std::uint8_t {
    idle,    ///< no recording
    wanted,  ///< requested by housekeeping: begin after the next tick
    running,
    full,     ///< a ring is full: the recording ends with the marks in it
    unwanted  ///< requested by housekeeping: end
  };

  /// Start-up: allocates.
  explicit RecordingTap(const Pipeline& pipeline)
      : checkpoint_{pipeline.state(),
                    {pipeline.protections().begin(), pipeline.protections().end()}} {}

  // The beat's side, real-time safe --------------------------------------------------------------

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

  /// The beat's observations around a tick.
  struct Around {
    std::int64_t woke_ns = 0;
    std::int64_t realtime_offset_ns = 0;
    std::uint32_t conditions = 0;
  };
  /// Ends the tick that made `record`; `pipeline` is in the state after it. At the beginning of a
  /// recording this copies that state, 1 MB.
  void tick_done(const TickRecord& record, const Around& around, const Pipeline& pipeline) noexcept;

  // Housekeeping's side --------------------------------------------------------------------------

  [[nodiscard]] State state() const noexcept { return state_.load(std::memory_order_acquire); }

  /// Call only when idle. After its next tick the beat changes to `running`: the first mark is of
  /// that tick and has no inputs, since the checkpoint is the state after it. The first call
  /// allocates.
  void begin();
  /// The beat changes back to `idle` after its next tick.
  void end() noexcept;
  /// Valid from `running` until end().
  [[nodiscard]] const Checkpoint& checkpoint() const noexcept { return checkpoint_; }

  /// The oldest mark, or null. Its inputs are in the rings already: pop them first, then the mark.
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
  bool taking_ = false;  // beat only: running, and all inputs of this tick fitted into the rings
  TickMark mark_;        // beat only: of the current tick
  Checkpoint checkpoint_;
  struct Rings {
    SpscRing<can::Frame, max_frames> frames;
    SpscRing<estimator::CameraPose, max_cameras> cameras;
    SpscRing<TickMark, max_ticks> marks;
  };
  std::unique_ptr<Rings> rings_;  // the beat uses them from `wanted` on
};

}  // namespace odomd::daemon
