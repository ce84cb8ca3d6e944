// Turns frames and camera poses into pose records. The live daemon and the offline replay share
// this object; only the clock and the frame source differ.
//
// Real-time safe after construction: no heap, no lock, no exception, no system call. One thread;
// statistics() and decoder() may be read from others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

#include <odom/types.h>

#include "can_protocol/decode/decoder.hpp"
#include "can_protocol/sources/stamp_guard.hpp"
#include "daemon/core/config.hpp"
#include "daemon/core/consistency.hpp"
#include "daemon/core/pipeline_statistics.hpp"
#include "daemon/core/record.hpp"
#include "daemon/core/source_watch.hpp"
#include "daemon/core/wiring.hpp"
#include "estimator/filter.hpp"

namespace odomd::daemon {

/// All state that one tick passes to the next, except the decoder's state and the counters. It owns
/// nothing and has no pointers, so its bytes are the complete state.
struct PipelineState {
  can::StampGuard stamp_guard;
  estimator::Filter filter;
  SourceWatch watch;
  Wiring wiring;
  std::array<Consistency, estimator::source_count> consistency{};
  TickRecord record;
  std::uint32_t outside_conditions = 0;
  bool camera_rejected = false;   ///< the last usable camera pose was gated or out of time
  std::int64_t start_ns = 0;      ///< of the first tick
  std::int64_t recovered_ns = 0;  ///< of the last tick that reset a non-finite state
  std::uint32_t recoveries = 0;
};
// Trivially destructible: std::construct_at replaces living states (restore(), RecordingTap). Not
// trivially copyable only because of Eigen 3.4's fixed-size vectors, which are plain numbers.
static_assert(std::is_trivially_destructible_v<PipelineState>);
static_assert(std::is_trivially_copyable_v<can::ProtectionState>);

class Pipeline {
 public:
  /// Start-up only: allocates, and throws std::invalid_argument when the configuration does not fit
  /// the databases. With `camera_expected` and no initial pose in the configuration, the first
  /// camera pose initialises the filter; otherwise the pose starts at the configured pose, or at
  /// zero.
  Pipeline(const Config& config, std::span<const can::Database> databases,
           std::span<const std::string> bus_names, bool camera_expected);

  /// Takes a frame with its time on the pipeline's clock. `now_ns` is the time of the drain (in a
  /// replay, of the tick); no stamp may be later.
  void take(const can::Frame& frame, std::int64_t now_ns) noexcept;

  /// Takes a camera pose of the reference point, with times on the pipeline's clock.
  void take(const estimator::CameraPose& reference) noexcept;

  /// Counts an invalid camera message as an unusable pose.
  void take_malformed_camera_message() noexcept;

  /// Sets the conditions that the pipeline cannot know (ODOM_COND_ bits: real time refused, bus
  /// down, ...). They hold until the next call.
  void set_conditions(std::uint32_t bits) noexcept { state_.outside_conditions = bits; }

  /// Resumes from the last pose of a predecessor, which is `gap_ns` old, and inflates its
  /// covariance for the gap. Returns false, and changes nothing, when the pose is not usable.
  bool resume(const odom_pose& pose, const odom_details& details, std::int64_t gap_ns) noexcept;

  /// Steps the filter to the tick that is valid at `tick_ns` and returns the record to publish.
  const TickRecord& tick(std::uint64_t number, std::int64_t tick_ns) noexcept;

  /// Valid between two ticks. From a copy, another pipeline with the same configuration continues
  /// with bit-identical results. Real-time safe.
  [[nodiscard]] const PipelineState& state() const noexcept { return state_; }
  [[nodiscard]] std::span<const can::ProtectionState> protections() const noexcept {
    return decoder_.protections();
  }
  /// `state` belongs to another pipeline; `protections` is as long as protections(). The counters
  /// start at zero.
  void restore(const PipelineState& state,
               std::span<const can::ProtectionState> protections) noexcept;

  /// The verdicts of the last tick on its samples, for models that test each sample at its own
  /// time. Valid until the next call.
  [[nodiscard]] std::span<const estimator::Judgement> judgements() const noexcept {
    return estimator::judgements(state_.filter);
  }

  [[nodiscard]] const PipelineStatistics& statistics() const noexcept { return statistics_; }
  [[nodiscard]] const can::Decoder& decoder() const noexcept { return decoder_; }

 private:
  void take_samples(std::span<can::Sample> samples, const can::Frame& frame,
                    can::StampVerdict stamp, std::int64_t now_ns) noexcept;
  void judge_camera(estimator::Verdict verdict, std::uint64_t samples = 1) noexcept;
  void count(std::size_t source, estimator::Verdict verdict, std::uint64_t samples = 1) noexcept;
  [[nodiscard]] estimator::SourceFlag flag_of(std::size_t source,
                                              std::int64_t tick_ns) const noexcept;
  [[nodiscard]] std::uint32_t conditions(const estimator::Estimate& estimate,
                                         std::int64_t tick_ns) const noexcept;

  can::Decoder decoder_;
  std::array<double, 3> camera_lever_arm_;
  double imu_yaw_;
  std::array<can::Sample, can::max_samples_per_frame> samples_;  ///< of the current frame
  PipelineState state_;
  PipelineStatistics statistics_;
};

}  // namespace odomd::daemon
