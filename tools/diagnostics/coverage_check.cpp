#include "tools/diagnostics/coverage_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "tools/math/median.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

// Larger than the jitter of a reference at rest.
constexpr double piece = 0.25;  // m
constexpr std::int64_t piece_ns = 200'000'000;
constexpr double least_way = 4.0 * piece;  // shorter references are not checked

/// The longest time between two rows of an estimate that is not a gap.
std::int64_t longest_of(const Trajectory& estimate) {
  constexpr std::int64_t usual_ns = 500'000'000;
  std::vector<std::int64_t> rows_ns;
  for (std::size_t i = 1; i < estimate.points.size(); ++i)
    rows_ns.push_back(estimate.points[i].t_ns - estimate.points[i - 1].t_ns);
  return rows_ns.empty() ? usual_ns : std::max(usual_ns, 3 * median_of(std::move(rows_ns)));
}

bool covers(const Trajectory& estimate, std::int64_t longest_ns, std::int64_t t_ns) {
  const auto& points = estimate.points;
  const auto after = std::ranges::lower_bound(points, t_ns, {}, &TrajectoryPoint::t_ns);
  if (after == points.end()) return false;
  if (after->t_ns == t_ns) return true;
  return after != points.begin() && after->t_ns - (after - 1)->t_ns <= longest_ns;
}

}  // namespace

std::optional<diagnostics::Diagnostic> check_coverage(const Trajectory& reference,
                                                      const Trajectory& estimate) {
  const std::int64_t longest_ns = longest_of(estimate);
  double whole_m = 0.0, covered_m = 0.0;
  std::int64_t covered_ns = 0;
  TrajectoryPoint from = reference.points.front();
  TrajectoryPoint before = from;
  for (const TrajectoryPoint& point : reference.points) {
    const bool is_covered = covers(estimate, longest_ns, point.t_ns);
    if (is_covered && covers(estimate, longest_ns, before.t_ns))
      covered_ns += point.t_ns - before.t_ns;
    before = point;
    const double step = distance(from.pose, point.pose);
    if (step < piece || point.t_ns - from.t_ns < piece_ns) continue;
    whole_m += step;
    if (is_covered && covers(estimate, longest_ns, from.t_ns)) covered_m += step;
    from = point;
  }
  constexpr const diagnostics::Kind& part = diagnostics::kind("estimate_covers_part");
  if (whole_m < least_way || part.limits.hold(covered_m / whole_m)) return std::nullopt;
  const auto seconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-9; };
  return found(
      part, estimate.name,
      fmt::format("it covers {:.1f} s and {:.1f} m of the reference's {:.1f} s and {:.1f} m",
                  seconds(covered_ns), covered_m,
                  seconds(reference.points.back().t_ns - reference.points.front().t_ns), whole_m));
}

}  // namespace odomd::tools
