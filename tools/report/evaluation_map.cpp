#include "tools/report/evaluation_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "tools/cli/text.hpp"
#include "tools/evaluation/evaluation_report.hpp"

namespace odomd::tools {
namespace {

std::vector<chart::Point> points_between(const Trajectory& trajectory, std::int64_t first_ns,
                                         std::int64_t last_ns) {
  std::vector<chart::Point> points;
  for (const TrajectoryPoint& point : trajectory.points) {
    if (point.t_ns >= first_ns && point.t_ns <= last_ns) {
      points.push_back({point.pose.x, point.pose.y});
    }
  }
  return points;
}

std::string note_of(const Evaluation& e) {
  if (e.against == Against::nothing) return {};
  const double degrees = std::abs(e.heading_end) * 180.0 / std::numbers::pi;
  std::string heading = fixed(degrees, degrees < 1.0 ? 2 : 1) + "°";
  if (!e.end_cm_per_m) return heading;
  return fixed(*e.end_cm_per_m, *e.end_cm_per_m < 0.1 ? 3 : 2) + " cm/m · " + heading;
}

}  // namespace

chart::Map evaluation_map(const EvaluatedDrive& drive, const std::string& title) {
  std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  double path = 0.0;
  for (const Evaluation& e : drive.report.evaluations) {
    first_ns = std::min(first_ns, e.first_ns);
    last_ns = std::max(last_ns, e.last_ns);
    path = std::max(path, e.path_length);
  }
  const auto names = names_of(drive);
  const auto colours = colours_of(drive);

  chart::Map map;
  map.title = title;
  if (const auto& reference = drive.reference ? drive.reference : drive.shown) {
    map.reference.label = drive.reference ? "reference" : "truth";
    map.reference.note = fixed(path, path < 1000.0 ? 1 : 0) + " m";
    map.reference.points = points_between(*reference, first_ns, last_ns);
  }
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    const Evaluation& e = drive.report.evaluations[i];
    const Trajectory moved = aligned(drive.estimates[i], e.alignment);
    chart::Trace trace{
        names[i], note_of(e), points_between(moved, e.first_ns, e.last_ns), {}, colours[i]};
    if (e.consistency) {
      const TrajectoryPoint end = *at(moved, e.last_ns);
      const auto& P = end.covariance;
      trace.end_ellipse = chart::Ellipse{{end.pose.x, end.pose.y}, {P[0], P[1], P[3]}};
    }
    map.estimates.push_back(std::move(trace));
  }
  for (const auto& pose : drive.cameras) {
    if (pose.capture_ns >= first_ns && pose.capture_ns <= last_ns) {
      map.dots.push_back({pose.x, pose.y});
    }
  }
  map.dots_label = drive.replays.empty() || camera_came_in(drive) ? "camera" : "camera, left out";
  return map;
}

}  // namespace odomd::tools
