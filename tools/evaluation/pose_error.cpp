#include "tools/evaluation/pose_error.hpp"

#include <numbers>
#include <optional>

#include <Eigen/Dense>

#include "estimator/common/symmetric3.hpp"
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

std::optional<double> nees(const estimator::PoseCovariance& P, const Pose2& error) {
  Eigen::Matrix3d full;
  full << P[0], P[1], P[2],  //
      P[1], P[3], P[4],      //
      P[2], P[4], P[5];
  const Eigen::LLT<Eigen::Matrix3d> factor{full};
  if (factor.info() != Eigen::Success) return std::nullopt;  // not positive definite
  const Eigen::Vector3d whitened =
      factor.matrixL().solve(Eigen::Vector3d{error.x, error.y, error.yaw});
  if (!whitened.allFinite()) return std::nullopt;
  return whitened.squaredNorm();
}

}  // namespace

bool covariance_is_of_error(std::span<const Pair> pairs, Align align) {
  if (align != Align::first) return align == Align::none;
  constexpr double small = 0.01;
  const auto& begin = pairs.front().estimate.covariance;
  const auto& end = pairs.back().estimate.covariance;
  constexpr std::array<std::size_t, 3> variances{0, 3, 5};
  return std::ranges::all_of(variances, [&](std::size_t i) { return begin[i] <= small * end[i]; });
}

std::vector<PoseError> pose_errors(std::span<const Pair> pairs, const Pose2& alignment,
                                   bool has_covariance) {
  const double c = std::cos(alignment.yaw);
  const double s = std::sin(alignment.yaw);
  std::vector<PoseError> errors;
  errors.reserve(pairs.size());
  double whole_turns = 0.0;
  std::optional<double> resets;
  for (const Pair& pair : pairs) {
    const Pose2 pose = compose(alignment, pair.estimate.pose);
    const Pose2& truth = pair.reference.pose;
    if (resets != pair.estimate.reset_count) {
      const double turn = pose.yaw - truth.yaw;
      whole_turns = turn - std::remainder(turn, 2.0 * std::numbers::pi);
      resets = pair.estimate.reset_count;
    }
    PoseError e;
    e.t_ns = pair.estimate.t_ns;
    e.error = {pose.x - truth.x, pose.y - truth.y, pose.yaw - truth.yaw - whole_turns};
    e.heading = truth.yaw;
    if (has_covariance) {
      e.covariance = estimator::rotated(pair.estimate.covariance, c, s);  // the map is turned
      for (std::size_t i = 0; i < e.covariance.size(); ++i)
        e.covariance[i] += pair.reference.covariance[i];
      e.nees = nees(e.covariance, e.error);
    }
    errors.push_back(e);
  }
  return errors;
}

DrivenError driven(const PoseError& error) {
  const double c = std::cos(error.heading);
  const double s = std::sin(error.heading);
  const estimator::Symmetric3 P = estimator::rotated(error.covariance, c, -s);
  const auto sigma = [](double variance) { return std::sqrt(std::max(variance, 0.0)); };
  return {.along = c * error.error.x + s * error.error.y,
          .cross = -s * error.error.x + c * error.error.y,
          .yaw = error.error.yaw,
          .sigma_along = sigma(P[0]),
          .sigma_cross = sigma(P[3]),
          .sigma_yaw = sigma(P[5])};
}

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
