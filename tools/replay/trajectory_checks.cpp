#include "tools/replay/replay_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "base/seconds.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/math/median.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using diagnostics::Diagnostic;
using diagnostics::Diagnostics;
using estimator::CameraPose;
using estimator::Pose2;

/// The longest time between two rows of an estimate that does not count as a gap.
std::int64_t max_step_of(const Trajectory& estimate) {
  constexpr std::int64_t usual_ns = 500'000'000;
  std::vector<std::int64_t> rows_ns;
  for (std::size_t i = 1; i < estimate.points.size(); ++i)
    rows_ns.push_back(estimate.points[i].t_ns - estimate.points[i - 1].t_ns);
  return rows_ns.empty() ? usual_ns : std::max(usual_ns, 3 * median_of(std::move(rows_ns)));
}

bool turns_otherwise(const Trajectory& reference, const Trajectory& estimate) {
  constexpr std::int64_t second_ns = 1'000'000'000;
  constexpr std::int64_t step_ns = second_ns / 10;
  constexpr std::size_t min_samples = 20;
  constexpr double min_turn = 0.1;  // rad per second, rms
  double difference = 0.0;
  double turned = 0.0;
  std::size_t samples = 0;
  const std::int64_t last =
      std::min(reference.points.back().t_ns, estimate.points.back().t_ns) - second_ns;
  for (std::int64_t t = std::max(reference.points.front().t_ns, estimate.points.front().t_ns);
       t <= last; t += step_ns) {
    const auto reference_from = at(reference, t), reference_to = at(reference, t + second_ns);
    const auto estimate_from = at(estimate, t), estimate_to = at(estimate, t + second_ns);
    if (!reference_from || !reference_to || !estimate_from || !estimate_to) continue;
    if (estimate_to->reset_count != estimate_from->reset_count) continue;
    const double reference_turn = reference_to->pose.yaw - reference_from->pose.yaw;
    const double estimate_turn = estimate_to->pose.yaw - estimate_from->pose.yaw;
    difference += std::pow(estimate_turn - reference_turn, 2);
    turned += reference_turn * reference_turn;
    ++samples;
  }
  return samples >= min_samples && turned > min_turn * min_turn * static_cast<double>(samples) &&
         !kind("other_drive").limits.hold(std::sqrt(difference / turned));
}

// Ratios per piece; their medians are robust against outliers and jumps of the filter.
struct Sizes {
  std::vector<double> distances;  ///< distance between the poses / distance driven
  std::vector<double> turns;      ///< relative error of their turn, read in degrees
};

Sizes sizes_of(std::span<const TrajectoryPoint> poses, const Trajectory& driven) {
  constexpr std::int64_t piece_ns = 500'000'000, longest_ns = 1'000'000'000;
  constexpr double min_distance = 0.1;  // m per piece; less may come from a wrong wheel scale
  constexpr double min_turn = 0.05;     // rad per piece
  Sizes sizes;
  for (std::size_t i = 0, j = 0; i < poses.size(); i = j) {
    while (j < poses.size() && poses[j].t_ns - poses[i].t_ns < piece_ns) ++j;
    if (j == poses.size()) break;
    if (poses[j].t_ns - poses[i].t_ns > longest_ns) continue;
    const auto from = at(driven, poses[i].t_ns), to = at(driven, poses[j].t_ns);
    if (!from || !to) continue;
    const double driven_m = distance(from->pose, to->pose);
    if (driven_m > min_distance)
      sizes.distances.push_back(distance(poses[i].pose, poses[j].pose) / driven_m);
    const double turn = to->pose.yaw - from->pose.yaw;
    const double read = std::remainder(poses[j].pose.yaw - poses[i].pose.yaw, 360.0);
    if (std::fabs(turn) > min_turn) sizes.turns.push_back(read / degrees / turn - 1.0);
  }
  return sizes;
}

/// The motion of the centre of gravity from the initial pose to the camera's pose.
Pose2 apart(const Pose2& initial, const CameraPose& seen, const Pose2& lever_arm) {
  return relative(initial, compose({seen.x, seen.y, seen.yaw}, inverse(lever_arm)));
}

double turn(const Pose2& motion) {
  return std::fabs(std::remainder(motion.yaw, 2.0 * std::numbers::pi));
}

}  // namespace

std::optional<Diagnostic> check_coverage(const Trajectory& reference, const Trajectory& estimate) {
  // Pieces are longer than the jitter of a reference at rest.
  constexpr double piece = 0.25;  // m
  constexpr std::int64_t piece_ns = 200'000'000;
  constexpr double min_distance = 4.0 * piece;  // shorter references are not checked
  const auto covers = [&, bridge_ns = max_step_of(estimate)](std::int64_t t_ns) {
    return at(estimate, t_ns, bridge_ns).has_value();
  };
  double whole_m = 0.0, covered_m = 0.0;
  std::int64_t covered_ns = 0;
  TrajectoryPoint from = reference.points.front();
  TrajectoryPoint before = from;
  for (const TrajectoryPoint& point : reference.points) {
    const bool is_covered = covers(point.t_ns);
    if (is_covered && covers(before.t_ns)) covered_ns += point.t_ns - before.t_ns;
    before = point;
    const double step = distance(from.pose, point.pose);
    if (step < piece || point.t_ns - from.t_ns < piece_ns) continue;
    whole_m += step;
    if (is_covered && covers(from.t_ns)) covered_m += step;
    from = point;
  }
  constexpr const diagnostics::Kind& part = kind("estimate_covers_part");
  if (whole_m < min_distance || part.limits.hold(covered_m / whole_m)) return std::nullopt;
  return found(
      part, estimate.name,
      fmt::format("it covers {:.1f} s and {:.1f} m of the reference's {:.1f} s and {:.1f} m",
                  seconds(covered_ns), covered_m,
                  seconds(reference.points.back().t_ns - reference.points.front().t_ns), whole_m));
}

std::optional<Diagnostic> drive_mismatch(const Trajectory& reference, const Trajectory& estimate) {
  if (turns_otherwise(reference, estimate))
    return found(kind("other_drive"), estimate.name, "its turns disagree with the reference's");
  if (reference.has_covariance && !estimate.has_covariance)
    return found(kind("exchanged"), estimate.name, "the reference has sigmas and this has none");
  return std::nullopt;
}

std::optional<Diagnostic> check_headings(const Trajectory& trajectory) {
  constexpr double piece = 0.2;  // m
  constexpr std::size_t min_pieces = 20;
  // The resultant R = |Σ exp(2i(χ − ψ))| / n, with χ the course over a piece of the path and ψ the
  // mean heading of its ends: 1 if they agree, whatever axis yaw counts from. The angle is doubled
  // because the heading of a reversing car is opposite to its course.
  double along = 0.0;
  double across = 0.0;
  std::size_t pieces = 0;
  Pose2 from = trajectory.points.front().pose;
  for (const TrajectoryPoint& point : trajectory.points) {
    const Pose2& to = point.pose;
    if (distance(from, to) < piece) continue;
    const double course = std::atan2(to.y - from.y, to.x - from.x);
    const double off_course = course - 0.5 * (from.yaw + to.yaw);
    along += std::cos(2.0 * off_course);
    across += std::sin(2.0 * off_course);
    ++pieces;
    from = to;
  }
  if (pieces < min_pieces) return std::nullopt;
  const double agreement = std::hypot(along, across) / static_cast<double>(pieces);
  constexpr const diagnostics::Kind& off_path = kind("headings_off_path");
  if (off_path.limits.hold(agreement)) return std::nullopt;
  return found(off_path, trajectory.name,
               "the headings do not follow the path (agreement " + fixed(agreement, 2) + " of 1)");
}

std::optional<Diagnostic> check_initial_pose(const daemon::Config& config,
                                             std::span<const CameraPose> cameras,
                                             std::int64_t first_tick_ns) {
  constexpr double soon_s = 0.2;
  constexpr double sigmas = 5.0;
  constexpr const diagnostics::Kind& elsewhere = kind("initial_pose_elsewhere");
  if (!config.initial_pose) return std::nullopt;
  const auto& arm = config.camera.lever_arm;
  const Pose2 lever_arm{arm[0], arm[1], arm[2]};
  const auto gap_s = [first_tick_ns](const CameraPose& seen) {
    return std::fabs(seconds(seen.capture_ns - first_tick_ns));
  };
  const auto is_soon = [&](const CameraPose& seen) { return gap_s(seen) <= soon_s; };
  const auto first = std::ranges::find_if(cameras, is_soon);
  if (first == cameras.end()) return std::nullopt;
  const auto last = std::ranges::find_if_not(first, cameras.end(), is_soon) - 1;

  // Speed between these poses; between first tick and a pose it may have been 1.5 times as high.
  const double between_s = std::max(seconds(last->capture_ns - first->capture_ns), 1e-3);
  const double speed = std::hypot(last->x - first->x, last->y - first->y) / between_s;
  const double rate = turn({0.0, 0.0, last->yaw - first->yaw}) / between_s;
  for (const CameraPose& seen : {*first, *last}) {  // either may be an outlier
    const Pose2 gap = apart(*config.initial_pose, seen, lever_arm);
    const double driven_s = 1.5 * gap_s(seen);
    const double beyond_m = std::hypot(gap.x, gap.y) - speed * driven_s -
                            sigmas * std::hypot(seen.sigma_x, seen.sigma_y);
    const double beyond_rad = turn(gap) - rate * driven_s - sigmas * seen.sigma_yaw;
    if (elsewhere.limits.hold(beyond_m) && elsewhere.limits.hold(beyond_rad)) return std::nullopt;
  }
  const Pose2 gap = apart(*config.initial_pose, *first, lever_arm);
  return found(elsewhere, config.file.string(),
               fmt::format("the initial pose ({:.2f} m, {:.2f} m, {:.0f} deg) lies {:.2f} m and "
                           "{:.0f} deg from what the camera saw first: it is of another drive",
                           config.initial_pose->x, config.initial_pose->y,
                           degrees * config.initial_pose->yaw, std::hypot(gap.x, gap.y),
                           degrees * turn(gap)));
}

Diagnostics check_units(const std::string& subject, std::span<const TrajectoryPoint> poses,
                        const Driven& driven) {
  constexpr std::size_t min_pieces = 10;
  constexpr double about = 3.0;      // tolerance factor, since wheels may spin
  constexpr double max_error = 0.5;  // relative error of a turn; 56/57 for radians
  Diagnostics result;
  const Sizes sizes = sizes_of(poses, driven.trajectory);
  const double ratio = sizes.distances.size() < min_pieces ? 1.0 : median_of(sizes.distances);
  for (const auto& [kind, times] : {std::pair{&tools::kind("positions_in_millimetres"), 1000},
                                    {&tools::kind("positions_in_centimetres"), 100}})
    if (ratio > times / about && ratio < times * about)
      result.push_back(
          found(*kind, subject,
                fmt::format("x and y go about {} times as far as {}", times, driven.way_of)));
  if (sizes.turns.size() >= min_pieces && median_of_magnitudes(sizes.turns) <= max_error)
    result.push_back(found(kind("yaw_in_degrees"), subject,
                           "yaw turns about 57 times as far as " + driven.turn_of));
  return result;
}

Diagnostics check_units(const std::string& subject, std::span<const estimator::CameraPose> poses,
                        const Driven& driven) {
  std::vector<TrajectoryPoint> points;
  points.reserve(poses.size());
  for (const estimator::CameraPose& pose : poses) {
    TrajectoryPoint& point = points.emplace_back();
    point.t_ns = pose.capture_ns;
    point.pose = {pose.x, pose.y, pose.yaw};
  }
  std::ranges::sort(points, {}, &TrajectoryPoint::t_ns);
  return check_units(subject, points, driven);
}

}  // namespace odomd::tools
