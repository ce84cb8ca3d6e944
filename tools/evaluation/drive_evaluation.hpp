// Replays of a drive with several models, their comparison with its reference, the score of a
// configuration, and a reference from the camera's poses.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/core/record.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/evaluation/evaluation.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Whether to keep the judgement of every sample: about 100 bytes each, several hundred per second
/// with the full filter.
enum class Judgements : std::uint8_t { forget, keep };

struct ReplayedDrive {
  Trajectory poses;         ///< one point per tick, on the log's clock, from initialisation on
  ReplaySummary summary;    ///< with verdicts and innovations per source
  daemon::TickRecord last;  ///< the last published record: calibrations, conditions
  diagnostics::Diagnostics warnings;
  /// In the order of the ticks that processed the samples; Judgement::time_ns is the sample's time.
  /// Only for models that test each sample.
  std::vector<estimator::Judgement> judgements;
};

/// Thrown if a replay gave no pose; has the warnings of the replay.
struct NoPose : std::invalid_argument {
  NoPose(const std::string& text, diagnostics::Diagnostics shown)
      : std::invalid_argument(text), warnings(std::move(shown)) {}
  diagnostics::Diagnostics warnings;
};

/// `config` is the drive's own or a changed copy (model, vehicle, noise, signals, initial pose,
/// ...); buses and databases are the drive's. The same inputs give the same bits, also in `odom
/// replay`. Throws std::invalid_argument for impossible settings, NoPose if there is no pose.
[[nodiscard]] ReplayedDrive replay_drive(const Drive& drive, const daemon::Config& config,
                                         Frame frame = Frame::map,
                                         Judgements judgements = Judgements::forget);

/// Evaluation::nis_factor, from the innovations of a replay.
[[nodiscard]] std::optional<double> nis_factor(const ReplaySummary& summary);

/// The motion from the car's own sensors, through the full filter, in the odometry frame. With
/// camera poses, the sensors' scales and offsets are learnt; without, the motion depends on the
/// bus's clock alone. Nothing if the replay gives no pose.
[[nodiscard]] std::optional<Trajectory> motion(const Drive& drive,
                                               std::span<const estimator::CameraPose> cameras = {});

/// The default alignment: none for map poses estimated with camera poses, which are in the
/// reference's frame already; `first` otherwise.
[[nodiscard]] constexpr Align usual_align(bool camera_poses_came_in, Frame frame) {
  return camera_poses_came_in && frame == Frame::map ? Align::none : Align::first;
}

/// The pose in the body frame of the point that truth.csv follows: [reference] lever_arm, or the
/// camera's if that is not set.
[[nodiscard]] estimator::Pose2 reference_arm(const daemon::Config& config);

/// The drive's reference, converted to the centre of gravity unless it is a camera reference.
[[nodiscard]] Trajectory reference_of(
    const Drive& drive, const std::optional<estimator::Pose2>& lever_arm = std::nullopt);

/// For a drive without truth.csv: uses its camera's poses as the reference, or else determines
/// whether it is a closed loop. Replays the drive.
void find_reference(Drive& drive);

/// The errors of a replay compared with a reference: mean displacement errors over 35 ms and 1 s
/// [m], rms of position [m] and heading [rad]; NaN: not determined.
using Score = std::array<double, 4>;

[[nodiscard]] Score score_of(const Evaluation& evaluation);

/// Errors of `tried` / errors of `before`: geometric mean of the ratios over drives and errors, so
/// that long or hard drives have no more weight. 1: as good; 0.9: a tenth better. Errors that are
/// NaN in `before` do not count; others that are NaN in `tried` make the result infinite.
[[nodiscard]] double relative_error(std::span<const Score> tried, std::span<const Score> before);

// A reference from the camera's poses, for a drive without truth.
//
// The pose at an instant comes from the camera's next poses, carried back with the odometry of the
// full filter, whose sensors the camera has calibrated. A filter never knows a pose that was taken
// after the instant for which it publishes. So no estimate uses the poses that it is compared with,
// and the comparison is not circular. docs/evaluation.md, "Drives without truth".

/// The camera's poses converted to the centre of gravity, in the order of their capture.
[[nodiscard]] Trajectory camera_trajectory(std::span<const estimator::CameraPose> poses,
                                           const estimator::Pose2& lever_arm);

/// One row for each row of the odometry that enough poses follow. Its covariance is the remaining
/// noise, from the scatter of these poses and not from their stated sigmas. Nothing if the rows
/// span less than a second.
[[nodiscard]] std::optional<Trajectory> camera_reference(const Trajectory& camera,
                                                         const Trajectory& odometry);

/// The reference of a drive from its camera poses, even if its replays leave the camera out.
/// Replays the drive. Nothing if there are no camera poses.
[[nodiscard]] std::optional<Trajectory> camera_reference(const Drive& drive);

}  // namespace odomd::tools
