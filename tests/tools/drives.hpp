// Artificial drives for tests of the evaluation.
#pragma once

#include "estimator/common/pose.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/cli/csv.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {

/// 1 m/s along a path whose heading oscillates and turns; a later start continues the same drive.
inline Trajectory wavy_drive(double from_s, double to_s, double step_s) {
  Trajectory drive;
  drive.name = "drive.csv";
  drive.has_motion = true;
  const auto ns = [](double s) { return static_cast<std::int64_t>(std::llround(s * 1e9)); };
  const auto yaw_at = [](double s) { return 0.3 * s + 0.8 * std::sin(s); };
  // ∫ (cos ψ, sin ψ) in steps of a millisecond from 0 on, independent of the rows
  double x = 0.0;
  double y = 0.0;
  const std::int64_t step_ns = ns(step_s);
  for (std::int64_t t = 0; t <= ns(to_s); t += 1'000'000) {
    const double s = static_cast<double>(t) * 1e-9;
    if (t >= ns(from_s) && (t - ns(from_s)) % step_ns == 0) {
      TrajectoryPoint point;
      point.t_ns = t;
      point.pose = {x, y, yaw_at(s)};
      point.motion = {1.0, 0.0, 0.3 + 0.8 * std::cos(s)};
      drive.points.push_back(point);
    }
    x += 1e-3 * std::cos(yaw_at(s + 0.5e-3));
    y += 1e-3 * std::sin(yaw_at(s + 0.5e-3));
  }
  return drive;
}

/// A drive at constant speed and yaw rate, starting at the origin at t = 0, heading along x.
inline Trajectory arc_drive(double speed, double yaw_rate, double seconds, double step_s) {
  Trajectory drive;
  drive.name = "arc.csv";
  for (std::int64_t i = 0; i <= std::llround(seconds / step_s); ++i) {
    TrajectoryPoint point;
    point.t_ns = i * std::llround(step_s * 1e9);
    point.pose =
        estimator::moved({}, {speed, 0.0, yaw_rate}, 1e-9 * static_cast<double>(point.t_ns));
    drive.points.push_back(point);
  }
  return drive;
}

inline Trajectory moved_by(const estimator::Pose2& motion, Trajectory trajectory) {
  for (auto& point : trajectory.points) point.pose = compose(motion, point.pose);
  return trajectory;
}

/// The trajectory as CSV: t,x,y,yaw.
inline std::string csv_of(const Trajectory& trajectory) {
  std::string text = "t,x,y,yaw\n";
  for (const auto& point : trajectory.points) {
    append_seconds(text, point.t_ns);
    for (const double value : {point.pose.x, point.pose.y, point.pose.yaw}) {
      text += ',';
      append_number(text, value);
    }
    text += '\n';
  }
  return text;
}

}  // namespace odomd::tools
