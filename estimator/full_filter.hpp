// The full filter: every sample fused at the time it was taken, however late it arrives.
//
// Samples wait in a window, in the order of their own times. A tick rewinds to the newest kept
// state before all new samples, and replays the samples from there. So the state at a tick depends
// on the samples alone, not on the order of their arrival, if each arrives inside the window.
//
// The work of a step is bounded: at most `max_bridged_ticks` plus the ticks within `reach_ns_`, and
// `SampleWindow::capacity` samples.
//
// A value; no heap, no clock.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "estimator/common/pose.hpp"
#include "estimator/common/settings.hpp"
#include "estimator/ekf/history.hpp"
#include "estimator/ekf/sample_window.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/ekf/take.hpp"
#include "estimator/integrity/camera_consistency.hpp"
#include "estimator/integrity/mode_monitor.hpp"

namespace odomd::estimator {

class FullFilter {
 public:
  explicit FullFilter(const FilterSettings& settings) noexcept;

  void set_initial_pose(const Pose2& pose) noexcept;
  bool resume(const Estimate& predecessor, double gap_s) noexcept;

  /// Returns nothing if the sample is judged at the next step(): see judgements().
  std::optional<Verdict> add(const Measurement& sample) noexcept;
  std::optional<Verdict> add(const CameraPose& camera) noexcept;
  Estimate step(std::int64_t tick_ns) noexcept;

  /// Judgements of the samples that the last step took for the first time. A later replay may
  /// decide otherwise. Valid until the next call.
  [[nodiscard]] std::span<const Judgement> judgements() const noexcept {
    return judgements_.reported();
  }

  /// Measured noise at the last tick, of a source whose samples state no sigma.
  [[nodiscard]] SourceNoise noise(Source source) const noexcept;

  [[nodiscard]] SourceFlag flag(Source source) const noexcept {
    return history_.now().integrity.flag(source);
  }

 private:
  std::optional<Verdict> insert(const full::Sample& sample, std::int64_t arrival_ns,
                                std::int64_t delay_ns) noexcept;
  void begin(std::int64_t tick_ns) noexcept;
  void count_resets() noexcept;
  void replay_to(std::int64_t tick_ns, BodyVelocity velocity) noexcept;
  void recover(std::int64_t tick_ns) noexcept;
  [[nodiscard]] Estimate estimate(std::int64_t tick_ns) noexcept;

  full::Context context_;
  std::array<double, source_count> sigma_;
  full::State initial_;  ///< state before the first sample
  std::int64_t period_ns_;
  std::int64_t window_ns_;  ///< largest delay of a sample
  std::int64_t reach_ns_;   ///< window_ns_ plus the largest learnt latency
  std::int64_t camera_latency_ns_;
  std::int64_t steering_delay_ns_;

  full::SampleWindow window_;
  full::History history_;  ///< now(): the state at the last tick
  std::optional<std::int64_t> last_tick_ns_;
  std::int64_t oldest_new_sample_ns_ = std::numeric_limits<std::int64_t>::max();

  full::Judgements judgements_;
  full::Latencies latencies_;

  integrity::CameraClock camera_clock_;
  ModeMonitor modes_;
  Pose2 odom_;
  bool odom_begun_ = false;
  std::uint32_t reset_count_ = 0;
  std::uint32_t published_resets_ = 0;  ///< resets of the state that was last published
  Pose2 published_jump_;                ///< last jump of that state
  Pose2 last_jump_;
  std::uint32_t recoveries_ = 0;
  Estimate last_;
};

}  // namespace odomd::estimator
