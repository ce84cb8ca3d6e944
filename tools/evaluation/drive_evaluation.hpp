// A drive replayed by several models and compared with its reference; and the score of one
// configuration on it.
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
  ReplaySummary summary;    ///< verdicts and innovations by source, too
  daemon::TickRecord last;  ///< the last published record: calibrations, conditions
  diagnostics::Diagnostics warnings;
  /// In the order of the ticks that took them in; Judgement::time_ns is the sample's own. Only for
  /// models that test each sample.
  std::vector<estimator::Judgement> judgements;
};

/// A drive whose replay gave no pose, and what the replay showed.
struct NoPose : std::invalid_argument {
  NoPose(const std::string& text, diagnostics::Diagnostics shown)
      : std::invalid_argument(text), warnings(std::move(shown)) {}
  diagnostics::Diagnostics warnings;
};

/// `config` is the drive's own or a changed copy of it (model, vehicle, noise, signals, initial
/// pose, ...); buses and databases are the drive's. The same inputs give the same bits, and those
/// of `odom replay`. Throws std::invalid_argument for impossible settings, NoPose for a drive
/// without a pose.
[[nodiscard]] ReplayedDrive replay_drive(const Drive& drive, const daemon::Config& config,
                                         Frame frame = Frame::map,
                                         Judgements judgements = Judgements::forget);

/// Evaluation::nis_factor of a replay.
[[nodiscard]] std::optional<double> nis_factor(const ReplaySummary& summary);

/// The motion by the car's own sensors, through the full filter, in the frame without jumps; with
/// the camera's poses their scales and offsets are learnt, without it is on the bus's clock alone.
/// Nothing if that gives no pose.
[[nodiscard]] std::optional<Trajectory> motion(const Drive& drive,
                                               std::span<const estimator::CameraPose> cameras = {});

/// The default alignment with the reference: none for poses with camera poses, which are in its
/// frame already; the odometry frame, without camera poses, needs one.
[[nodiscard]] constexpr Align usual_align(bool camera_poses_came_in, Frame frame) {
  return camera_poses_came_in && frame == Frame::map ? Align::none : Align::first;
}

/// The pose in the body frame of the point that truth.csv follows: [reference] lever_arm, else the
/// camera's.
[[nodiscard]] estimator::Pose2 reference_arm(const daemon::Config& config);

/// The drive's reference, of the centre of gravity; that of the camera is so already.
[[nodiscard]] Trajectory reference_of(
    const Drive& drive, const std::optional<estimator::Pose2>& lever_arm = std::nullopt);

/// For a drive without truth.csv: its camera's poses as the reference, else whether it is a closed
/// loop. Needs a replay.
void find_reference(Drive& drive);

/// The errors of a replay with a reference: mean displacement error over 35 ms and over 1 s [m],
/// rms of position [m] and of heading [rad]; NaN if the drive does not determine it.
using Score = std::array<double, 4>;

[[nodiscard]] Score score_of(const Evaluation& evaluation);

/// The errors of `tried` over those of `before`: the geometric mean of the ratios over drives and
/// errors, so that no drive weighs more for being long or hard. 1: as good; 0.9: a tenth better.
/// What a drive did not determine before does not count; what it no longer determines is infinitely
/// bad.
[[nodiscard]] double relative_error(std::span<const Score> tried, std::span<const Score> before);

}  // namespace odomd::tools
