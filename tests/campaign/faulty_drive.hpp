// Runs a drive through the daemon's pipeline, with and without faults, and compares each tick with
// the truth. Used by the integrity and source-flag campaigns.
//
// The part before the fault is the same in all runs, so it is replayed only once: every run
// continues from the pipeline's state at its end.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/core/pipeline.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/fault/fault.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::campaign {

/// The error of a pose, and its quality information.
struct Tick {
  double position_m = 0.0;
  double yaw_rad = 0.0;
  double sigmas = 0.0;  ///< the larger of the position's Mahalanobis distance and |yaw|/sigma
  bool initialised = false;
  std::uint32_t mode = 0;
  std::uint32_t conditions = 0;
  std::uint32_t health = 0;
  std::array<std::uint8_t, estimator::source_count> flags{};  ///< estimator::SourceFlag
};

/// The ticks of one run, from the beginning of the fault or of the whole drive.
using Run = std::vector<Tick>;

enum class Camera : std::uint8_t { off, on };

/// A drive with the ticks of its replay.
struct Drive : tools::Drive {
  std::int64_t first_tick_ns = 0;
  std::size_t ticks = 0;

  [[nodiscard]] std::int64_t start_ns() const { return frames.front().time_ns; }
  [[nodiscard]] std::int64_t tick_ns(std::size_t tick) const {
    return first_tick_ns + static_cast<std::int64_t>(tick) * config.realtime.period_ns;
  }
  /// Seconds after the first frame, the clock of faults.
  [[nodiscard]] double seconds_at(std::int64_t time_ns) const {
    return static_cast<double>(time_ns - start_ns()) * 1e-9;
  }
  /// Start time of a fault that first affects the tick after `tick` [s].
  [[nodiscard]] double begin_s(std::size_t tick) const { return seconds_at(tick_ns(tick) + 1); }
};

/// Throws std::invalid_argument for a drive without its truth.
[[nodiscard]] Drive read_drive(const tools::DriveFiles& files);

/// What a car with faults sends during the drive.
struct Sent {
  std::vector<can::Frame> frames;
  std::vector<estimator::CameraPose> cameras;
};
[[nodiscard]] Sent sent(const Drive& drive, std::span<const fault::Fault> faults);

/// The runs of a drive in which all faults begin at the same tick.
class FaultyDrive {
 public:
  /// Replays the drive without faults. `drive` must outlive this. `begin`: the last tick before the
  /// faults.
  FaultyDrive(const Drive& drive, Camera camera, std::size_t begin);

  /// The drive without faults, from its first tick on.
  [[nodiscard]] const Run& healthy() const noexcept { return healthy_; }
  /// From the tick after `begin` on.
  [[nodiscard]] Run with(std::span<const fault::Fault> faults) const;
  [[nodiscard]] Run without(fault::Sources sources) const;

 private:
  [[nodiscard]] std::unique_ptr<daemon::Pipeline> pipeline(fault::Sources left_out) const;
  [[nodiscard]] Tick tick(daemon::Pipeline& pipeline, std::size_t number) const;
  [[nodiscard]] std::unique_ptr<daemon::Pipeline> resumed(fault::Sources left_out) const;
  [[nodiscard]] Run play(daemon::Pipeline& pipeline, std::span<const can::Frame> frames,
                         std::span<const estimator::CameraPose> cameras, std::size_t from,
                         std::size_t to) const;

  const Drive& drive_;
  Camera camera_;
  std::size_t begin_;
  std::vector<std::optional<tools::TrajectoryPoint>> truth_;  ///< by tick
  std::size_t frames_before_ = 0;                             ///< frames before the faults
  std::size_t cameras_before_ = 0;
  std::unique_ptr<daemon::PipelineState> state_;  ///< state after `begin`
  std::vector<can::ProtectionState> protections_;
  Run healthy_;
};

}  // namespace odomd::campaign
