#include "tools/evaluation/drive_evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/evaluation/pose_error.hpp"
#include "tools/math/median.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using estimator::Pose2;

// In half a second a usual camera (28 Hz) takes 14 poses, and the speed error of a car's sensors
// hardly changes. A slower camera needs a longer window.
constexpr std::int64_t usual_window_ns = 500'000'000;
constexpr std::int64_t longest_window_ns = 2'000'000'000;
constexpr std::int64_t poses_in_window = 5;
constexpr std::size_t least_poses = 4;  // to estimate the scatter about a line
constexpr std::int64_t least_ns = 1'000'000'000;

double nearest_turn(double angle, double near) {
  return near + std::remainder(angle - near, 2.0 * std::numbers::pi);
}

/// A camera pose, and the odometry's pose at its time.
struct Seen {
  std::int64_t t_ns = 0;
  Pose2 camera;
  Pose2 odometry;
};

std::vector<Seen> seen_by(const Trajectory& camera, const Trajectory& odometry) {
  std::vector<Seen> all;
  for (const TrajectoryPoint& point : camera.points)
    if (const auto there = at(odometry, point.t_ns))
      all.push_back({point.t_ns, point.pose, there->pose});
  return all;
}

/// How far two consecutive poses contradict the odometry between them.
struct Contradiction {
  double distance = 0.0;
  double turn = 0.0;
};

Contradiction between(const Seen& a, const Seen& b) {
  const Pose2 there = estimator::compose(a.camera, relative(a.odometry, b.odometry));
  return {distance(there, b.camera),
          std::fabs(std::remainder(b.camera.yaw - there.yaw, 2.0 * std::numbers::pi))};
}

/// Drops poses that contradict both neighbours by over ten times the median of a moving car: the
/// camera took another object for the car. Normal noise practically never reaches this, and a jump
/// of the map contradicts one neighbour only.
void drop_outliers(std::vector<Seen>& seen) {
  constexpr double most = 10.0;
  constexpr double moves_m = 1e-3;  // a camera may repeat a standing car's pose to the last digit
  std::vector<Contradiction> steps;
  std::vector<double> distances, turns;  // while moving
  for (std::size_t i = 1; i < seen.size(); ++i) {
    steps.push_back(between(seen[i - 1], seen[i]));
    if (distance(seen[i - 1].odometry, seen[i].odometry) < moves_m) continue;
    distances.push_back(steps.back().distance);
    turns.push_back(steps.back().turn);
  }
  if (distances.empty()) return;
  const double far = most * median_of(std::move(distances));
  const double askew = most * median_of(std::move(turns));
  const auto fits = [&](std::size_t step) {
    return steps[step].distance <= far && steps[step].turn <= askew;
  };
  std::vector<Seen> kept;
  for (std::size_t i = 0; i < seen.size(); ++i)
    if ((i > 0 && fits(i - 1)) || (i < steps.size() && fits(i))) kept.push_back(seen[i]);
  seen = std::move(kept);
}

std::int64_t length_of_windows(const std::vector<Seen>& seen) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < seen.size(); ++i) steps.push_back(seen[i].t_ns - seen[i - 1].t_ns);
  return std::clamp(poses_in_window * median_of(std::move(steps)), usual_window_ns,
                    longest_window_ns);
}

/// A line through one coordinate of the poses after an instant, carried back to the instant with
/// the odometry. An error of the odometry's speed makes the coordinate drift with the lag: `slope`.
struct Line {
  double mean = 0.0;
  double slope = 0.0;
  double scatter = 0.0;  ///< about the line, as variance of a pose
};
struct Window {
  TrajectoryPoint now;
  double count = 0.0;
  double mean_lag = 0.0;  ///< [s]
  double lags = 0.0;      ///< sum of squared deviations from mean_lag [s²]
  double yaw = 0.0;
  double yaw_variance = 0.0;  ///< variance of the mean yaw
  Line x, y;
};

template <typename Value>
double mean_of(std::span<const Seen> poses, const Value& value) {
  double sum = 0.0;
  for (const Seen& pose : poses) sum += value(pose);
  return sum / static_cast<double>(poses.size());
}

template <typename Value, typename Lag>
Line line_of(std::span<const Seen> poses, const Window& window, const Value& value,
             const Lag& lag) {
  Line line;
  line.mean = mean_of(poses, value);
  for (const Seen& pose : poses)
    line.slope += (lag(pose) - window.mean_lag) * (value(pose) - line.mean) / window.lags;
  for (const Seen& pose : poses)
    line.scatter +=
        std::pow(value(pose) - line.mean - line.slope * (lag(pose) - window.mean_lag), 2);
  line.scatter /= window.count - 2.0;
  return line;
}

Window window_of(std::span<const Seen> next, const TrajectoryPoint& now) {
  const Pose2& from = now.pose;
  Window window{.now = now, .count = static_cast<double>(next.size()), .x = {}, .y = {}};
  const auto lag = [&now](const Seen& pose) {
    return static_cast<double>(pose.t_ns - now.t_ns) * 1e-9;
  };
  window.mean_lag = mean_of(next, lag);
  for (const Seen& pose : next) window.lags += std::pow(lag(pose) - window.mean_lag, 2);
  const auto yaw_by = [&](const Seen& pose) {
    const Pose2& first = next.front().camera;
    return nearest_turn(pose.camera.yaw,
                        first.yaw + pose.odometry.yaw - next.front().odometry.yaw) -
           (pose.odometry.yaw - from.yaw);
  };
  window.yaw = mean_of(next, yaw_by);
  for (const Seen& pose : next)
    window.yaw_variance +=
        std::pow(yaw_by(pose) - window.yaw, 2) / (window.count * (window.count - 1.0));
  const double c = std::cos(window.yaw - from.yaw);
  const double s = std::sin(window.yaw - from.yaw);
  window.x = line_of(
      next, window,
      [&](const Seen& pose) {
        return pose.camera.x - c * (pose.odometry.x - from.x) + s * (pose.odometry.y - from.y);
      },
      lag);
  window.y = line_of(
      next, window,
      [&](const Seen& pose) {
        return pose.camera.y - s * (pose.odometry.x - from.x) - c * (pose.odometry.y - from.y);
      },
      lag);
  return window;
}

/// Variances over a drive: of a camera pose, and of the odometry's speed error.
struct Variances {
  double pose = 0.0;
  double speed = 0.0;
};

Variances variances_of(const std::vector<Window>& windows) {
  Variances all;
  const double axes = 2.0 * static_cast<double>(windows.size());
  for (const Window& window : windows) all.pose += (window.x.scatter + window.y.scatter) / axes;
  for (const Window& window : windows)
    all.speed +=
        (std::pow(window.x.slope, 2) + std::pow(window.y.slope, 2) - 2.0 * all.pose / window.lags) /
        axes;
  all.speed = std::max(all.speed, 0.0);
  return all;
}

/// The car's pose: the lines at zero lag. Their slopes have less weight if speed errors are small.
TrajectoryPoint carried_back(const Window& window, const Variances& variances) {
  // Noise is removed later, but a speed error that a filter shares would add to the filter's own
  // error. Therefore slopes are weighted as if speed errors were twice as large.
  const double weight = 4.0 * variances.speed * window.lags;
  const double believed = weight > 0.0 ? weight / (weight + variances.pose) : 0.0;
  const auto at_no_lag = [&](const Line& line) {
    return line.mean - believed * line.slope * window.mean_lag;
  };
  const double variance =
      variances.pose / window.count +
      std::pow(window.mean_lag, 2) * (std::pow(believed, 2) * variances.pose / window.lags +
                                      std::pow(1.0 - believed, 2) * variances.speed);
  TrajectoryPoint point;
  point.t_ns = window.now.t_ns;
  point.pose = {at_no_lag(window.x), at_no_lag(window.y), window.yaw};
  point.covariance = {variance, 0.0, 0.0, variance, 0.0, window.yaw_variance};
  return point;
}

}  // namespace

Trajectory camera_trajectory(std::span<const estimator::CameraPose> poses, const Pose2& lever_arm) {
  Trajectory trajectory;
  trajectory.name = "camera.csv";
  for (const estimator::CameraPose& pose : poses) {
    TrajectoryPoint point;
    point.t_ns = pose.capture_ns;
    point.pose = {pose.x, pose.y, pose.yaw};
    trajectory.points.push_back(point);
  }
  auto& points = trajectory.points;
  std::ranges::stable_sort(points, {}, &TrajectoryPoint::t_ns);
  const auto same_time = [](const TrajectoryPoint& a, const TrajectoryPoint& b) {
    return a.t_ns == b.t_ns;
  };
  points.erase(std::unique(points.begin(), points.end(), same_time), points.end());
  for (std::size_t i = 1; i < points.size(); ++i)
    points[i].pose.yaw = nearest_turn(points[i].pose.yaw, points[i - 1].pose.yaw);
  return at_centre_of_gravity(trajectory, lever_arm);
}

std::optional<Trajectory> camera_reference(const Trajectory& camera, const Trajectory& odometry) {
  std::vector<Seen> seen = seen_by(camera, odometry);
  drop_outliers(seen);
  if (seen.size() < least_poses) return std::nullopt;
  const std::int64_t window_ns = length_of_windows(seen);
  std::vector<Window> windows;
  auto first = seen.begin();
  auto last = seen.begin();
  for (const TrajectoryPoint& now : odometry.points) {
    while (first != seen.end() && first->t_ns <= now.t_ns) ++first;
    last = std::max(last, first);
    while (last != seen.end() && last->t_ns - now.t_ns <= window_ns) ++last;
    const std::span<const Seen> next(first, last);
    if (next.size() >= least_poses) windows.push_back(window_of(next, now));
  }
  const Variances variances = variances_of(windows);
  Trajectory reference;
  reference.name = camera.name;
  reference.is_camera = true;
  reference.has_covariance = true;
  reference.bridge_ns = window_ns;
  std::optional<double> turned;  // yaw of the reference relative to the odometry
  for (const Window& window : windows) {
    TrajectoryPoint point = carried_back(window, variances);
    const double yaw = window.now.pose.yaw;
    if (turned) point.pose.yaw = nearest_turn(point.pose.yaw, yaw + *turned);
    turned = point.pose.yaw - yaw;
    reference.points.push_back(point);
  }
  if (reference.points.empty() ||
      reference.points.back().t_ns - reference.points.front().t_ns < least_ns)
    return std::nullopt;
  return reference;
}

std::optional<Trajectory> camera_reference(const Drive& drive) {
  const auto& poses = drive.cameras.empty() ? drive.cameras_left_out : drive.cameras;
  if (poses.empty()) return std::nullopt;
  const std::optional<Trajectory> odometry = motion(drive, poses);
  if (!odometry) return std::nullopt;
  const auto& arm = drive.config.camera.lever_arm;
  return camera_reference(camera_trajectory(poses, {arm[0], arm[1], arm[2]}), *odometry);
}

}  // namespace odomd::tools
