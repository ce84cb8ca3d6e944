#include "tools/diagnostics/heading_check.hpp"

#include <cmath>
#include <cstddef>

#include "tools/cli/text.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

constexpr double piece = 0.2;             // m
constexpr std::size_t least_pieces = 20;  // fewer do not suffice

}  // namespace

std::optional<diagnostics::Diagnostic> check_headings(const Trajectory& trajectory) {
  // The resultant R = |Σ exp(2i(χ − ψ))| / n, χ the course over a piece of the way, ψ the mean of
  // the headings at its ends: 1 if they agree, whatever axis yaw counts from. Doubled, because a
  // car that reverses has its heading against its course.
  double along = 0.0;
  double across = 0.0;
  std::size_t pieces = 0;
  estimator::Pose2 from = trajectory.points.front().pose;
  for (const TrajectoryPoint& point : trajectory.points) {
    const estimator::Pose2& to = point.pose;
    if (distance(from, to) < piece) continue;
    const double course = std::atan2(to.y - from.y, to.x - from.x);
    const double off_course = course - 0.5 * (from.yaw + to.yaw);
    along += std::cos(2.0 * off_course);
    across += std::sin(2.0 * off_course);
    ++pieces;
    from = to;
  }
  if (pieces < least_pieces) return std::nullopt;
  const double agreement = std::hypot(along, across) / static_cast<double>(pieces);
  constexpr const diagnostics::Kind& off_path = diagnostics::kind("headings_off_path");
  if (off_path.limits.hold(agreement)) return std::nullopt;
  return found(off_path, trajectory.name,
               "the headings do not follow the path (agreement " + fixed(agreement, 2) + " of 1)");
}

}  // namespace odomd::tools
