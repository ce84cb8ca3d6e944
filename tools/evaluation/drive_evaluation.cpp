#include "tools/evaluation/drive_evaluation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <utility>

#include "daemon/core/pipeline.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/evaluation/evaluation.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

ReplayedDrive replay_with(const Drive& drive, const daemon::Config& config, Frame frame,
                          Judgements judgements,
                          std::span<const estimator::CameraPose> cameras) try {
  ReplayedDrive result;
  result.poses.name = drive.name;
  result.poses.has_motion = true;
  result.poses.has_covariance = frame == Frame::map;

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
  result.summary.unmapped = drive.unmapped.size();
  result.warnings = check_replay(pipeline->decoder(), result.summary);
  if (result.poses.points.empty()) {
    // The first warning is the cause if the database is another car's, otherwise the last.
    const auto& first = result.warnings.front();
    const bool is_cause = first.kind == &kind("other_database");
    throw NoPose(drive.folder.string() + ": " + text_of(is_cause ? first : result.warnings.back()),
                 result.warnings);
  }
  return result;
} catch (const NoPose&) {
  throw;
} catch (const std::invalid_argument& error) {
  throw std::invalid_argument(drive.folder.string() + ": " + error.what());
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Smaller errors count as equal, as their ratio has no meaning.
constexpr double least_error = 1e-9;

}  // namespace

ReplayedDrive replay_drive(const Drive& drive, const daemon::Config& config, Frame frame,
                           Judgements judgements) {
  return replay_with(drive, config, frame, judgements, drive.cameras);
}

std::optional<Trajectory> motion(const Drive& drive,
                                 std::span<const estimator::CameraPose> cameras) {
  daemon::Config config = drive.config;
  config.model = estimator::Model::full;
  try {
    ReplayedDrive replayed = replay_with(drive, config, Frame::odom, Judgements::forget, cameras);
    if (replayed.summary.fault_ns) return std::nullopt;
    return std::move(replayed.poses);
  } catch (const std::invalid_argument&) {  // the caller that needs the poses reports it
    return std::nullopt;
  }
}

std::optional<double> nis_factor(const ReplaySummary& summary) {
  double logarithms = 0.0;
  int sources = 0;
  for (const daemon::InnovationStatistics& source : summary.innovations) {
    if (source.count == 0 || !(source.mean_nis() > 0.0)) continue;
    logarithms += std::fabs(std::log(source.nis_per_degree()));
    ++sources;
  }
  if (sources == 0) return std::nullopt;
  return std::exp(logarithms / sources);
}

void find_reference(Drive& drive) {
  if (drive.reference) return;
  drive.reference = camera_reference(drive);
  if (drive.reference) return;
  const std::optional<Trajectory> odometry = motion(drive);
  if (!odometry || odometry->points.size() < 2) return;
  drive.closed_loop = closes(evaluate_closed_loop(*odometry));
}

estimator::Pose2 reference_arm(const daemon::Config& config) {
  const auto& [x, y, yaw] = config.reference_lever_arm.value_or(config.camera.lever_arm);
  return {x, y, yaw};
}

Trajectory reference_of(const Drive& drive, const std::optional<estimator::Pose2>& lever_arm) {
  if (drive.reference->is_camera) return *drive.reference;
  return at_centre_of_gravity(*drive.reference, lever_arm.value_or(reference_arm(drive.config)));
}

Score score_of(const Evaluation& evaluation) {
  Score score{unknown, unknown, evaluation.position.rms, evaluation.heading.rms};
  constexpr std::array horizons{short_horizon_ns, std::int64_t{1'000'000'000}};
  for (std::size_t i = 0; i < horizons.size(); ++i)
    if (const HorizonError* const error = error_over(evaluation, horizons[i]))
      score[i] = error->displacement.mean;
  return score;
}

double relative_error(std::span<const Score> tried, std::span<const Score> before) {
  double logarithms = 0.0;
  std::size_t count = 0;
  for (std::size_t drive = 0; drive < before.size(); ++drive) {
    for (std::size_t i = 0; i < before[drive].size(); ++i) {
      if (std::isnan(before[drive][i])) continue;
      if (!std::isfinite(tried[drive][i])) return std::numeric_limits<double>::infinity();
      logarithms += std::log(std::max(tried[drive][i], least_error) /
                             std::max(before[drive][i], least_error));
      ++count;
    }
  }
  return count == 0 ? 1.0 : std::exp(logarithms / static_cast<double>(count));
}

}  // namespace odomd::tools
