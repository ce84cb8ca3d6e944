// Frames and camera messages in, a pose record out: the one object that the live daemon and the
// offline replay share. Only the clock and the frame source differ around it.
//
// Real-time safe after construction: no heap, no lock, no exception, no system call. One thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <odom/odom.h>
#include <odom/types.h>

#include "can_protocol/counter.hpp"
#include "can_protocol/decoder.hpp"
#include "can_protocol/stamp_guard.hpp"
#include "daemon/config.hpp"
#include "estimator/filter.hpp"

namespace odomd::daemon {

/// Counts that housekeeping and `odom status` read while the beat runs.
struct SourceStatistics {
  std::array<Counter, estimator::verdict_count> verdicts;
  Counter last_time_ns;     ///< time of the newest sample (bit pattern of the signed time)
  Counter last_verdict;     ///< an estimator::Verdict
  Counter last_test_ratio;  ///< bit pattern of the double; camera only for now
};

struct PipelineStatistics {
  std::array<SourceStatistics, estimator::source_count> sources;
  std::array<Counter, static_cast<std::size_t>(can::FrameVerdict::count)> frames;
  std::array<Counter, can::stamp_verdict_count> stamps;
  Counter camera_malformed;  ///< messages of the wrong size, magic, version or clock
};

struct TickRecord {
  odom_pose pose{};
  odom_details details{};
  bool initialised = false;  ///< the pose means something: replay writes rows from here on
};

class Pipeline {
 public:
  Pipeline(const Config& config, std::span<const can::Database> databases,
           std::span<const std::string> bus_names, bool camera_expected);

  /// Takes a frame in. Its time must already be on the pipeline's clock.
  void take(const can::Frame& frame, std::int64_t now_ns) noexcept;

  /// Takes a camera pose of the reference point in, times on the pipeline's clock.
  void take(const estimator::CameraPose& pose) noexcept;

  /// Conditions that only the surroundings know (real time refused, bus down, ...), for the next
  /// tick.
  void set_conditions(std::uint32_t bits) noexcept { outside_conditions_ = bits; }

  /// Goes on from a predecessor's pose, its covariance grown for the gap.
  void resume(const odom_pose& pose, std::int64_t gap_ns) noexcept;

  /// Steps the filter to the tick that is valid at `tick_ns` and returns what is to be published.
  const TickRecord& tick(std::uint64_t number, std::int64_t tick_ns) noexcept;

  [[nodiscard]] const PipelineStatistics& statistics() const noexcept { return statistics_; }
  [[nodiscard]] const can::Decoder& decoder() const noexcept { return decoder_; }

  void count_malformed_camera_message() noexcept;

 private:
  can::Decoder decoder_;
  can::StampGuard stamp_guard_;
  estimator::Filter filter_;
  PipelineStatistics statistics_;
  TickRecord record_;
  std::uint32_t outside_conditions_ = 0;
};

}  // namespace odomd::daemon
