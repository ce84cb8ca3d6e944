// A drive through the pipeline and what came of it, all in memory: what `odom evaluate --drive`
// shows, and what a search for better settings asks for many times.
//
// Free functions of what they are given: any number of threads may replay one drive at once, each
// with a configuration of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/core/record.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/evaluation/evaluation.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Whether to keep how every single sample was judged: about 100 bytes each, and the full filter
/// judges some hundred a second.
enum class Judgements : std::uint8_t { forget, keep };

struct ReplayedDrive {
  Trajectory poses;         ///< a point a tick, on the log's clock, from initialisation on
  ReplaySummary summary;    ///< verdicts and innovations by source, too
  daemon::TickRecord last;  ///< what was published at the end: calibrations, conditions
  std::vector<std::string> doubts;
  /// In the order of the ticks that took them in; Judgement::time_ns is the sample's own. Of the
  /// models that test each sample; of the others none.
  std::vector<estimator::Judgement> judgements;
};

/// `config` is the drive's own or a changed copy of it (model, vehicle, noise, signals, initial
/// pose, ...); buses and databases are the drive's. The same inputs give the same bits, and those
/// of `odom replay`. The camera's poses can be left out. Throws std::invalid_argument for settings
/// that are impossible, and for a drive during which no pose came about.
[[nodiscard]] ReplayedDrive replay_drive(const Drive& drive, const daemon::Config& config,
                                         Frame frame = Frame::map,
                                         Judgements judgements = Judgements::forget,
                                         CameraUse camera = CameraUse::take);

/// How the car moved by its own sensors alone, through the full filter: of the bus and its clock,
/// whatever a camera says. Nothing where no pose comes of that.
[[nodiscard]] std::optional<Trajectory> dead_reckoning(const Drive& drive);

/// How poses are brought to the reference where nobody says it: by camera poses, which are in its
/// frame, they are there already; the odometry frame, into which none goes, is not.
[[nodiscard]] constexpr Align usual_align(bool camera_poses_came_in, Frame frame) {
  return camera_poses_came_in && frame == Frame::map ? Align::none : Align::first;
}

/// How a drive is held against its reference.
struct Measure {
  std::optional<Align> align;  ///< else usual_align()
  Frame frame = Frame::map;
  std::optional<estimator::Pose2> lever_arm;  ///< of the reference's point in the body frame
};

/// replay_drive() and evaluate(). Throws std::invalid_argument where the drive has no reference,
/// too.
[[nodiscard]] Evaluation evaluate_drive(const Drive& drive, const daemon::Config& config,
                                        const Measure& measure = {});

}  // namespace odomd::tools
