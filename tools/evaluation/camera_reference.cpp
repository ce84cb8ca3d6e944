#include "tools/evaluation/camera_reference.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/evaluation/alignment.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/math/median.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using estimator::Pose2;

// Over half a second the sensors' drift is millimetres, and the noise of 14 poses of a usual camera
// (28 Hz) a quarter of that of one. A slower camera needs longer, up to a drift like its noise.
constexpr std::int64_t usual_window_ns = 500'000'000;
constexpr std::int64_t longest_window_ns = 2'000'000'000;
constexpr std::int64_t poses_in_window = 5;
constexpr std::size_t least_poses = 3;  // for a scatter
constexpr std::int64_t least_ns = 1'000'000'000;

double nearest_turn(double angle, double near) {
  return near + std::remainder(angle - near, 2.0 * std::numbers::pi);
}

/// A pose of the camera and the odometry's at its time.
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

std::int64_t window_of(const std::vector<Seen>& seen) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < seen.size(); ++i) steps.push_back(seen[i].t_ns - seen[i - 1].t_ns);
  return std::clamp(poses_in_window * median_of(std::move(steps)), usual_window_ns,
                    longest_window_ns);
}

/// Mean and variance of the mean.
struct Mean {
  double value = 0.0;
  double variance = 0.0;
};
template <typename Value>
Mean mean_of(std::span<const Seen> poses, const Value& value) {
  const auto count = static_cast<double>(poses.size());
  Mean mean;
  for (const Seen& pose : poses) mean.value += value(pose) / count;
  for (const Seen& pose : poses)
    mean.variance += std::pow(value(pose) - mean.value, 2) / (count * (count - 1.0));
  return mean;
}

/// Where the car was at `now`, by the poses that came next.
TrajectoryPoint carried_back(std::span<const Seen> next, const TrajectoryPoint& now) {
  const Pose2& from = now.pose;
  const auto yaw_by = [&from](const Seen& pose) {
    return pose.camera.yaw - (pose.odometry.yaw - from.yaw);
  };
  const Mean yaw = mean_of(
      next, [&](const Seen& pose) { return nearest_turn(yaw_by(pose), yaw_by(next.front())); });
  const double c = std::cos(yaw.value - from.yaw);
  const double s = std::sin(yaw.value - from.yaw);
  const auto driven_x = [&](const Seen& pose) {
    return c * (pose.odometry.x - from.x) - s * (pose.odometry.y - from.y);
  };
  const auto driven_y = [&](const Seen& pose) {
    return s * (pose.odometry.x - from.x) + c * (pose.odometry.y - from.y);
  };
  const Mean x = mean_of(next, [&](const Seen& pose) { return pose.camera.x - driven_x(pose); });
  const Mean y = mean_of(next, [&](const Seen& pose) { return pose.camera.y - driven_y(pose); });
  // A heading that is off turns what was driven.
  const double dx = mean_of(next, driven_x).value;
  const double dy = mean_of(next, driven_y).value;
  TrajectoryPoint point;
  point.t_ns = now.t_ns;
  point.pose = {x.value, y.value, yaw.value};
  point.covariance = {
      x.variance + dy * dy * yaw.variance, -dx * dy * yaw.variance, dy * yaw.variance,
      y.variance + dx * dx * yaw.variance, -dx * yaw.variance,      yaw.variance};
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
  const std::vector<Seen> seen = seen_by(camera, odometry);
  if (seen.size() < least_poses) return std::nullopt;
  const std::int64_t window_ns = window_of(seen);
  Trajectory reference;
  reference.name = camera.name;
  reference.is_camera = true;
  reference.has_covariance = true;
  reference.bridge_ns = usual_window_ns;
  auto first = seen.begin();
  auto last = seen.begin();
  std::optional<double> turned;  // of the reference against the odometry
  for (const TrajectoryPoint& now : odometry.points) {
    while (first != seen.end() && first->t_ns <= now.t_ns) ++first;
    last = std::max(last, first);
    while (last != seen.end() && last->t_ns - now.t_ns <= window_ns) ++last;
    const std::span<const Seen> next(first, last);
    if (next.size() < least_poses) continue;
    TrajectoryPoint point = carried_back(next, now);
    if (turned) point.pose.yaw = nearest_turn(point.pose.yaw, now.pose.yaw + *turned);
    turned = point.pose.yaw - now.pose.yaw;
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
