// A drive in virtual time: the daemon's own pipeline on the tick grid of the log's clock, as fast
// as the machine allows. The same inputs give the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "can_protocol/frame.hpp"
#include "daemon/core/pipeline_statistics.hpp"
#include "daemon/core/record.hpp"
#include "daemon/core/wiring.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/diagnostics/log_order.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::daemon {
class Pipeline;
}

namespace odomd::tools {

/// The first tick of a log: its first stamp rounded up to a multiple of the period.
[[nodiscard]] constexpr std::int64_t first_tick_ns(std::int64_t first_stamp_ns,
                                                   std::int64_t period_ns) {
  const std::int64_t remainder = first_stamp_ns % period_ns;
  return remainder == 0 ? first_stamp_ns : first_stamp_ns - remainder + period_ns;
}

struct ReplaySummary {
  std::uint64_t frames = 0;
  std::uint64_t unmapped = 0;  ///< further frames of the log, of no mapped message
  std::uint64_t cameras = 0;
  std::uint64_t cameras_before = 0;  ///< of these, arrived before the first tick
  std::uint64_t cameras_after = 0;   ///< arrived after the last tick
  double camera_delay_s = 0.0;       ///< median, from the capture to the arrival
  std::uint64_t ticks = 0;
  std::uint64_t late = 0;   ///< frames stamped late_ns or more before the tick that used them
  std::uint64_t poses = 0;  ///< ticks from initialisation on
  std::int64_t first_tick_ns = 0;
  std::int64_t last_tick_ns = 0;
  std::uint32_t last_mode = 0;           ///< an odom_mode
  std::optional<std::int64_t> fault_ns;  ///< first tick in the mode fault
  std::uint64_t faulty = 0;              ///< ticks in the mode fault
  std::uint32_t fault_conditions = 0;    ///< ODOM_COND_ bits at fault_ns

  // Per source.
  std::array<daemon::InnovationStatistics, estimator::source_count> innovations;
  std::array<estimator::SourceNoise, estimator::source_count> noise;  ///< at the last tick
  std::array<std::array<std::uint64_t, estimator::verdict_count>, estimator::source_count>
      verdicts{};
  std::array<std::array<std::uint64_t, estimator::source_flag_names.size()>,
             estimator::source_count>
      flagged{};  ///< ticks with each flag
  std::array<std::array<std::uint64_t, daemon::wiring_names.size()>, estimator::source_count>
      wired{};  ///< ticks with each daemon::WiringFault
  std::array<std::uint64_t, estimator::source_count> inconsistent{};  ///< ticks

  // Ticks with these conditions; for the bias, only while the car moves.
  std::uint64_t bias_unlearnt = 0;
  std::uint64_t scale_implausible = 0;

  /// The path from wheels and gyro alone, a point every 0.1 s.
  Trajectory odometry;
  /// Findings on the units of the camera's poses, from a comparison with that path.
  diagnostics::Diagnostics camera_units;

  /// Adds a tick; `time_ns` is on the clock of the log.
  void add_tick(const daemon::Pipeline& pipeline, const daemon::TickRecord& record,
                std::int64_t time_ns);
  /// Adds what is known after the last tick.
  void finish(const daemon::Pipeline& pipeline,
              std::span<const estimator::CameraPose> camera_poses);
};

/// The longest pause in a log; a longer one means a log of two drives.
inline constexpr std::int64_t longest_pause_ns = 3600LL * 1'000'000'000;

/// A pause that is too long: the log has two drives, or a wrong stamp.
class PauseError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The next frame, valid until the next call; nullptr at the end.
using NextFrame = std::function<const can::Frame*()>;
using PoseSink = std::function<void(const daemon::TickRecord&)>;
/// How a tick judged its samples; valid until the sink returns.
using JudgementSink = std::function<void(std::span<const estimator::Judgement>)>;

/// Tick k uses the frames stamped <= T_k and the camera poses that arrived by T_k (sorted by
/// arrival). The last tick is the first that has used every frame. `sink` receives every record
/// from initialisation on, `judged` the judgements of every tick. Throws PauseError at the frame
/// after a pause longer than longest_pause_ns.
ReplaySummary replay(daemon::Pipeline& pipeline, std::int64_t period_ns,
                     const NextFrame& next_frame, std::span<const estimator::CameraPose> cameras,
                     const PoseSink& sink, const JudgementSink& judged = {});

}  // namespace odomd::tools
