#include "tools/diagnostics/unit_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "tools/math/median.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

constexpr std::int64_t piece_ns = 500'000'000;
constexpr std::int64_t longest_ns = 1'000'000'000;
constexpr std::size_t fewest = 10;   // pieces
constexpr double least_way = 0.1;    // m per piece; less may come from a wrong scale of the wheels
constexpr double least_turn = 0.05;  // rad per piece
constexpr double about = 3.0;        // tolerance factor, since wheels may spin
constexpr double alike = 0.5;        // relative error of a turn; poses in radians have 56/57

constexpr double in_degrees = 180.0 / std::numbers::pi;

// Ratios per piece; their medians are robust against outliers and jumps of the filter.
struct Sizes {
  std::vector<double> ways;   ///< distance between the poses / distance driven
  std::vector<double> turns;  ///< relative error of their turn, read in degrees
};

Sizes sizes_of(std::span<const TrajectoryPoint> poses, const Trajectory& driven) {
  Sizes sizes;
  for (std::size_t i = 0, j = 0; i < poses.size(); i = j) {
    while (j < poses.size() && poses[j].t_ns - poses[i].t_ns < piece_ns) ++j;
    if (j == poses.size()) break;
    if (poses[j].t_ns - poses[i].t_ns > longest_ns) continue;
    const auto from = at(driven, poses[i].t_ns), to = at(driven, poses[j].t_ns);
    if (!from || !to) continue;
    const double way = distance(from->pose, to->pose);
    if (way > least_way) sizes.ways.push_back(distance(poses[i].pose, poses[j].pose) / way);
    const double turn = to->pose.yaw - from->pose.yaw;
    const double degrees = std::remainder(poses[j].pose.yaw - poses[i].pose.yaw, 360.0);
    if (std::fabs(turn) > least_turn) sizes.turns.push_back(degrees / in_degrees / turn - 1.0);
  }
  return sizes;
}

bool is_about(double ratio, double factor) {
  return ratio > factor / about && ratio < factor * about;
}

using diagnostics::Diagnostics;
using diagnostics::found;
using diagnostics::kind;

void check_distances(const std::string& subject, const std::vector<double>& ways,
                     const std::string& whose, Diagnostics& result) {
  if (ways.size() < fewest) return;
  const double ratio = median_of(ways);
  const auto report = [&](const diagnostics::Kind& kind, const std::string& times) {
    result.push_back(
        found(kind, subject, "x and y go about " + times + " times as far as " + whose));
  };
  if (is_about(ratio, 1000.0)) report(kind("positions_in_millimetres"), "1000");
  if (is_about(ratio, 100.0)) report(kind("positions_in_centimetres"), "100");
}

}  // namespace

Diagnostics check_units(const std::string& subject, std::span<const TrajectoryPoint> poses,
                        const Driven& driven) {
  Diagnostics result;
  const Sizes sizes = sizes_of(poses, driven.trajectory);
  check_distances(subject, sizes.ways, driven.way_of, result);
  if (sizes.turns.size() >= fewest && median_of_magnitudes(sizes.turns) <= alike)
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
