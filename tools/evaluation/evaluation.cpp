#include "tools/evaluation/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>

#include "estimator/common/symmetric3.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using estimator::Pose2;

constexpr double fastest_car = kind("reference_jumps").limits.most;
constexpr double standing = 0.1;  // m: a reference that stays within this distance shows only
                                  // noise, as no car turns so tightly

// The reference's rows between two times, and its interpolated ends. A camera reference gives one
// row per tenth of a second, as its noise would lengthen the path.
std::vector<TrajectoryPoint> piece(const Trajectory& reference, std::int64_t first_ns,
                                   std::int64_t last_ns) {
  std::vector<TrajectoryPoint> points{*at(reference, first_ns)};
  const std::int64_t step_ns = reference.is_camera ? 100'000'000 : 0;
  for (const TrajectoryPoint& point : reference.points)
    if (point.t_ns > points.back().t_ns + step_ns && point.t_ns < last_ns) points.push_back(point);
  points.push_back(*at(reference, last_ns));
  return points;
}

// Length and extent of the path, its jumps and its longest gap.
void add_path(std::span<const TrajectoryPoint> path, Evaluation& result) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step = distance(path[i - 1].pose, path[i].pose);
    const std::int64_t gap_ns = path[i].t_ns - path[i - 1].t_ns;
    result.path_length += step;
    result.farthest = std::max(result.farthest, distance(path.front().pose, path[i].pose));
    result.reference_gap_ns = std::max(result.reference_gap_ns, gap_ns);
    if (step > fastest_car * static_cast<double>(gap_ns) * 1e-9) ++result.reference_jumps;
  }
}

// Time for which the reference repeats one position, as many trackers do when they lose the car.
std::int64_t stuck_ns(std::span<const Pair> pairs) {
  constexpr double still = 0.005;  // m, maximum motion of the reference
  constexpr double driven = 0.5;   // m, minimum motion of the estimate
  constexpr std::int64_t shortest_ns = 1'000'000'000;
  std::int64_t all_ns = 0;
  for (std::size_t first = 0; first < pairs.size();) {
    const Pair& begin = pairs[first];
    TrajectoryPoint from = begin.estimate;  // a jump of the pose is not motion
    double away = 0.0;
    std::size_t end = first + 1;
    for (; end < pairs.size(); ++end) {
      if (distance(begin.reference.pose, pairs[end].reference.pose) > still) break;
      const TrajectoryPoint& now = pairs[end].estimate;
      if (now.reset_count != from.reset_count) from = now;
      away = std::max(away, distance(from.pose, now.pose));
    }
    const std::int64_t stood_ns = pairs[end - 1].estimate.t_ns - begin.estimate.t_ns;
    if (stood_ns >= shortest_ns && away > driven) all_ns += stood_ns;
    first = end;
  }
  return all_ns;
}

estimator::BodyVelocity velocity_rms(std::span<const Pair> pairs) {
  Gathered vx, vy, yaw_rate;
  for (const auto& [estimate, reference] : pairs) {
    vx.add(std::abs(estimate.motion.v_x - reference.motion.v_x));
    vy.add(std::abs(estimate.motion.v_y - reference.motion.v_y));
    yaw_rate.add(std::abs(estimate.motion.yaw_rate - reference.motion.yaw_rate));
  }
  return {vx.spread().rms, vy.spread().rms, yaw_rate.spread().rms};
}

// The camera's noise is independent of the estimate's errors: their squares add up.
void take_out_noise(std::span<const Pair> pairs, Evaluation& result) {
  double position = 0.0;
  double heading = 0.0;
  for (const Pair& pair : pairs) {
    const estimator::PoseCovariance& noise = pair.reference.covariance;
    position += (noise[0] + noise[3]) / static_cast<double>(pairs.size());
    heading += noise[5] / static_cast<double>(pairs.size());
  }
  // The noise is known to a few per cent: errors below a fifth of the noise may be undetected.
  constexpr double least = 0.2;
  const auto without = [](double rms, double variance) {
    return std::sqrt(std::max(rms * rms - variance, least * least * variance));
  };
  result.against = Against::camera;
  result.reference_noise = std::sqrt(position);
  result.position.rms = without(result.position.rms, position);
  result.heading.rms = without(result.heading.rms, heading);
}

constexpr double least_path = 1.0;        // m
constexpr double refused_of_path = 0.10;  // end error
constexpr double refused_of_size = 0.5;
constexpr double refused_turn = 45.0;  // deg
constexpr double warn_share_of_path = 0.03;
constexpr double warn_turn = 20.0;  // deg

double degrees_off(const Evaluation& e) {
  return std::abs(e.heading_end) * degrees;
}

// Largest ratio of an error to its limit; above 1 the lap is refused.
double excess(const Evaluation& e) {
  return std::max({e.end_error / (refused_of_path * e.path_length),
                   e.end_error / (refused_of_size * std::max(e.farthest, 1e-9)),
                   degrees_off(e) / refused_turn});
}

std::string how_far(const Evaluation& e) {
  return fixed(e.end_error, 2) + " m (" + fixed(100.0 * e.end_error / e.path_length, 1) + " % of " +
         fixed(e.path_length, 1) + " m) and " + fixed(degrees_off(e), 0) + " deg from its start";
}

bool closes_badly(const Evaluation& e) {
  return e.end_error > warn_share_of_path * e.path_length || degrees_off(e) > warn_turn;
}

const Evaluation& best_of(std::span<const Evaluation> evaluations) {
  return *std::ranges::min_element(evaluations, {}, [](const Evaluation& e) {
    return std::pair{e.path_length < least_path, excess(e)};
  });
}

}  // namespace

const HorizonError* error_over(const Evaluation& e, std::int64_t horizon_ns) {
  const auto found = std::ranges::find(e.horizons, horizon_ns, &HorizonError::horizon_ns);
  return found == e.horizons.end() ? nullptr : &*found;
}

Evaluation evaluate(const Trajectory& reference, const Trajectory& estimate, Align align) {
  const auto pairs = common_times(reference, estimate);
  Evaluation result;
  result.name = estimate.name;
  result.samples = pairs.size();
  result.first_ns = pairs.front().estimate.t_ns;
  result.last_ns = pairs.back().estimate.t_ns;
  add_path(piece(reference, result.first_ns, result.last_ns), result);
  if (reference.is_camera) result.reference_gap_ns = 0;  // gaps are not interpolated
  result.reference_stuck_ns = stuck_ns(pairs);
  result.alignment = alignment(pairs, align);

  Gathered position, heading, consistency;
  std::size_t inside_95 = 0;
  const auto errors = pose_errors(pairs, result.alignment,
                                  estimate.has_covariance && covariance_is_of_error(pairs, align));
  for (const PoseError& e : errors) {
    position.add(std::hypot(e.error.x, e.error.y));
    heading.add(std::abs(e.error.yaw));
    if (!e.nees) continue;
    consistency.add(*e.nees);
    if (*e.nees <= chi_squared_95_of_3) ++inside_95;
  }
  result.position = position.spread();
  result.heading = heading.spread();
  if (reference.is_camera) take_out_noise(pairs, result);
  const Pose2& end = errors.back().error;
  result.end_error = std::hypot(end.x, end.y);
  result.heading_end = end.yaw;
  if (result.farthest > standing)
    result.end_cm_per_m = 100.0 * result.end_error / result.path_length;
  if (consistency.count() > 0) {
    const auto count = static_cast<double>(consistency.count());
    result.consistency = Consistency{consistency.spread().mean,
                                     static_cast<double>(inside_95) / count, consistency.count()};
  }
  result.horizons = horizon_errors(reference, estimate, pairs);
  // Within short horizons reference poses may share camera poses: odometry gives their distance.
  if (reference.is_camera)
    std::erase_if(result.horizons,
                  [&](const HorizonError& e) { return e.horizon_ns < 2 * reference.bridge_ns; });
  if (reference.has_motion && estimate.has_motion) result.velocity_rms = velocity_rms(pairs);
  return result;
}

Trajectory aligned(const Trajectory& estimate, const Pose2& alignment) {
  Trajectory moved = estimate;
  for (TrajectoryPoint& point : moved.points) {
    point.pose = compose(alignment, point.pose);
    point.covariance =
        estimator::rotated(point.covariance, std::cos(alignment.yaw), std::sin(alignment.yaw));
  }
  return moved;
}

Evaluation evaluate_closed_loop(const Trajectory& estimate) {
  const auto& points = estimate.points;
  if (points.size() < 2) {
    throw std::invalid_argument(estimate.name + ": has one row only; a lap needs more");
  }
  Evaluation e;
  e.against = Against::closed_loop;
  e.name = estimate.name;
  e.samples = points.size();
  e.first_ns = points.front().t_ns;
  e.last_ns = points.back().t_ns;
  add_path(points, e);
  e.end_error = distance(points.front().pose, points.back().pose);
  e.heading_end =
      std::remainder(points.back().pose.yaw - points.front().pose.yaw, 2.0 * std::numbers::pi);
  if (e.path_length > 0.0) e.end_cm_per_m = 100.0 * e.end_error / e.path_length;
  return e;
}

bool closes(const Evaluation& loop) {
  return loop.path_length >= least_path && excess(loop) <= 1.0 && !closes_badly(loop);
}

Evaluation without_errors(const Evaluation& open) {
  Evaluation e = open;
  e.against = Against::nothing;
  e.end_error = e.heading_end = 0.0;
  e.end_cm_per_m.reset();
  return e;
}

std::optional<diagnostics::Diagnostic> check_that_it_closes(
    const std::string& drive, std::span<const Evaluation> evaluations) {
  const Evaluation* const best = &best_of(evaluations);
  if (best->path_length < least_path) {
    throw std::invalid_argument(drive + ": the car hardly moves (" + fixed(best->path_length, 2) +
                                " m); a closed loop needs a lap");
  }
  if (excess(*best) > 1.0) {
    throw std::invalid_argument(
        drive + ": the lap does not close: according to the best estimate it ends " +
        how_far(*best) + "; cut it to whole laps with --from and --to, or give a --reference");
  }
  if (closes_badly(*best)) {
    return found(kind("loop_closes_badly"), drive,
                 "the lap closes badly: according to the best estimate it ends " + how_far(*best));
  }
  return std::nullopt;
}

}  // namespace odomd::tools
