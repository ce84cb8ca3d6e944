// Reads trajectories from files with the columns t,x,y,yaw and, if present, vx,vy,yaw_rate:
// references and outputs of odom replay. Converts published poses to points of a trajectory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <odom/types.h>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/estimate.hpp"
#include "estimator/common/pose.hpp"

namespace odomd::tools {

struct TrajectoryPoint {
  std::int64_t t_ns = 0;
  estimator::Pose2 pose;           ///< yaw unwrapped: no step between rows exceeds half a turn
  estimator::BodyVelocity motion;  ///< if Trajectory::has_motion
  estimator::PoseCovariance covariance{};  ///< if Trajectory::has_covariance
  double reset_count = 0.0;  ///< number of jumps of the pose; 0 if the file does not contain it
};

/// The columns of a reference; a pose file has more.
inline constexpr auto point_columns = [](auto&& cell, auto& point) {
  cell("t", point.t_ns);
  cell("x", point.pose.x);
  cell("y", point.pose.y);
  cell("yaw", point.pose.yaw);
  cell("vx", point.motion.v_x);
  cell("vy", point.motion.v_y);
  cell("yaw_rate", point.motion.yaw_rate);
};

struct Trajectory {
  std::string name;                     ///< the file as the user named it
  std::vector<TrajectoryPoint> points;  ///< at least one; times strictly increasing
  bool has_motion = false;
  bool has_covariance = false;  ///< from sigma_x, sigma_y, sigma_yaw; off-diagonals if given
  std::vector<std::vector<double>> columns;  ///< the requested further columns, a value per point;
                                             ///< empty: not in the file
  bool is_camera = false;  ///< a camera's poses as a reference: the covariance is their noise
  /// A longer gap between two rows is not interpolated.
  std::int64_t bridge_ns = std::numeric_limits<std::int64_t>::max();
  diagnostics::Diagnostics warnings;
};

/// Which of the poses in a pose file to read.
enum class Frame : std::uint8_t {
  map,   ///< x, y, yaw: jumps when a filter uses a camera pose or is reset
  odom,  ///< odom_x, odom_y, odom_yaw: without jumps and without covariance
};

/// Throws std::invalid_argument with file, line and column if the file is not usable: a missing
/// column, a field that is not a finite number, times that run backwards, no row at all. A repeated
/// time gives a warning, and its first row is used.
[[nodiscard]] Trajectory read_trajectory(const std::filesystem::path& file,
                                         Frame frame = Frame::map,
                                         const std::vector<std::string>& further = {});

/// The same for a stream; messages call it `name`.
[[nodiscard]] Trajectory read_trajectory(std::istream& input, const std::string& name,
                                         Frame frame = Frame::map,
                                         const std::vector<std::string>& further = {});

/// The point at a time, interpolated linearly, also velocities and covariance (yaw is unwrapped, so
/// it turns the shorter way). Empty if the time is outside the span or in a gap over bridge_ns.
[[nodiscard]] std::optional<TrajectoryPoint> at(const Trajectory& trajectory, std::int64_t t_ns);

/// The same with another limit for gaps.
[[nodiscard]] std::optional<TrajectoryPoint> at(const Trajectory& trajectory, std::int64_t t_ns,
                                                std::int64_t bridge_ns);

/// The point at a time between `a` and `b`, interpolated linearly.
[[nodiscard]] TrajectoryPoint between(const TrajectoryPoint& a, const TrajectoryPoint& b,
                                      std::int64_t t_ns);

/// The rows between two times, both included. Throws std::invalid_argument if there is none.
[[nodiscard]] Trajectory cut_to(Trajectory trajectory, std::int64_t from_ns, std::int64_t to_ns);

[[nodiscard]] inline TrajectoryPoint point_of(const odom_pose& pose, Frame frame) {
  TrajectoryPoint point;
  point.t_ns = pose.time_ns;
  point.pose = frame == Frame::odom ? estimator::Pose2{pose.odom_x, pose.odom_y, pose.odom_yaw}
                                    : estimator::Pose2{pose.x, pose.y, pose.yaw};
  point.motion = {pose.vx, pose.vy, pose.yaw_rate};
  for (std::size_t i = 0; i < point.covariance.size(); ++i) {
    point.covariance[i] = pose.covariance[i];
  }
  if (frame == Frame::map) point.reset_count = pose.reset_count;
  return point;
}

}  // namespace odomd::tools
