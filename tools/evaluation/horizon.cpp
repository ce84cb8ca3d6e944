#include "tools/evaluation/horizon.hpp"

#include <cmath>
#include <optional>

#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using estimator::Pose2;

// Poses of a trajectory at non-decreasing times within its span.
class Walk {
 public:
  explicit Walk(const Trajectory& trajectory)
      : points_(trajectory.points), bridge_ns_(trajectory.bridge_ns) {}

  /// Nothing in a gap.
  [[nodiscard]] std::optional<Pose2> at(std::int64_t t_ns) {
    while (points_[after_].t_ns < t_ns) ++after_;
    const TrajectoryPoint& b = points_[after_];
    if (b.t_ns == t_ns) return b.pose;
    const TrajectoryPoint& a = points_[after_ - 1];
    if (b.t_ns - a.t_ns > bridge_ns_) return std::nullopt;
    return between(a, b, t_ns).pose;
  }

 private:
  std::span<const TrajectoryPoint> points_;
  std::int64_t bridge_ns_;
  std::size_t after_ = 0;
};

std::optional<HorizonError> error_over(std::int64_t horizon_ns, const Trajectory& reference,
                                       const Trajectory& estimate, std::span<const Pair> pairs) {
  Gathered displacement, yaw;
  Walk true_way(reference);
  Walk estimated_way(estimate);
  const std::int64_t last_ns = pairs.back().estimate.t_ns;
  for (const Pair& pair : pairs) {
    const std::int64_t later_ns = pair.estimate.t_ns + horizon_ns;
    if (later_ns > last_ns) break;
    const std::optional<Pose2> there = estimated_way.at(later_ns);
    const std::optional<Pose2> true_there = true_way.at(later_ns);
    if (!there || !true_there) continue;
    const Pose2 d = relative(pair.estimate.pose, *there);
    const Pose2 d_true = relative(pair.reference.pose, *true_there);
    displacement.add(std::hypot(d_true.x - d.x, d_true.y - d.y));
    yaw.add(std::abs(d.yaw - d_true.yaw));
  }
  if (displacement.count() == 0) return std::nullopt;
  return HorizonError{horizon_ns, displacement.spread(), yaw.spread(), displacement.count()};
}

}  // namespace

std::vector<HorizonError> horizon_errors(const Trajectory& reference, const Trajectory& estimate,
                                         std::span<const Pair> pairs) {
  std::vector<HorizonError> errors;
  for (const std::int64_t horizon_ns : horizons_ns) {
    if (const auto error = error_over(horizon_ns, reference, estimate, pairs))
      errors.push_back(*error);
  }
  return errors;
}

}  // namespace odomd::tools
