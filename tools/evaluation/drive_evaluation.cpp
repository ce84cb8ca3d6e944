#include "tools/evaluation/drive_evaluation.hpp"

#include <memory>
#include <span>
#include <stdexcept>
#include <utility>

#include "daemon/core/pipeline.hpp"
#include "tools/drive_files/pose_point.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
ReplayedDrive replay_drive(const Drive& drive, const daemon::Config& config, Frame frame,
                           Judgements judgements, CameraUse camera) try {
  ReplayedDrive result;
  result.poses.name = drive.name;
  result.poses.has_motion = true;
  result.poses.has_covariance = frame == Frame::map;

  std::span<const estimator::CameraPose> cameras;
  if (camera == CameraUse::take) cameras = drive.cameras;
  const auto pipeline =
      std::make_unique<daemon::Pipeline>(config, drive.databases, drive.buses, !cameras.empty());
  JudgementSink keep;
  if (judgements == Judgements::keep) {
    keep = [&result](std::span<const estimator::Judgement> some) {
      result.judgements.insert(result.judgements.end(), some.begin(), some.end());
    };
  }
  auto next = drive.frames.begin();
  result.summary = replay(
      *pipeline, config.realtime.period_ns,
      [&]() -> const can::Frame* { return next == drive.frames.end() ? nullptr : &*next++; },
      cameras,
      [&](const daemon::TickRecord& record) {
        result.poses.points.push_back(point_of(record.pose, frame));
        result.last = record;
      },
      keep);
  result.warnings = check_replay(pipeline->decoder(), result.summary);
  if (result.poses.points.empty()) {
    throw std::invalid_argument(
        text_of(result.warnings.back()));  // which says what is missing for a pose
  }
  return result;
} catch (const std::invalid_argument& error) {
  throw std::invalid_argument(drive.folder.string() + ": " + error.what());
}

std::optional<Trajectory> dead_reckoning(const Drive& drive) {
  daemon::Config config = drive.config;
  config.model = estimator::Model::full;
  try {
    ReplayedDrive replayed =
        replay_drive(drive, config, Frame::odom, Judgements::forget, CameraUse::leave_out);
    if (replayed.summary.fault_ns) return std::nullopt;
    return std::move(replayed.poses);
  } catch (const std::invalid_argument&) {  // the caller that needs the poses reports it
    return std::nullopt;
  }
}

Evaluation evaluate_drive(const Drive& drive, const daemon::Config& config,
                          const Measure& measure) {
  if (!drive.reference) {
    throw std::invalid_argument(drive.folder.string() +
                                ": has no truth.csv to compare with; put the true poses there "
                                "(t,x,y,yaw)");
  }
  const ReplayedDrive replayed = replay_drive(drive, config, measure.frame);
  return evaluate(measure.lever_arm ? at_centre_of_gravity(*drive.reference, *measure.lever_arm)
                                    : *drive.reference,
                  replayed.poses,
                  measure.align.value_or(usual_align(!drive.cameras.empty(), measure.frame)));
}

}  // namespace odomd::tools
