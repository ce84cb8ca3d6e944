#include "tools/evaluation.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

#include "tools/se2.hpp"

namespace odomd::tools {
namespace {

using estimator::Pose2;

// Mean, rms and maximum of magnitudes as they come in.
class Gathered {
 public:
  void add(double magnitude) {
    sum_ += magnitude;
    squares_ += magnitude * magnitude;
    max_ = std::max(max_, magnitude);
    ++count_;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] Spread spread() const {
    const auto n = static_cast<double>(std::max<std::size_t>(count_, 1));
    return {sum_ / n, std::sqrt(squares_ / n), max_};
  }

 private:
  double sum_ = 0.0;
  double squares_ = 0.0;
  double max_ = 0.0;
  std::size_t count_ = 0;
};

constexpr double fastest_car = 100.0;  // m/s

double distance(const Pose2& a, const Pose2& b) {
  return std::hypot(b.x - a.x, b.y - a.y);
}

// The rows of the reference between two times, and its interpolated ends.
std::vector<TrajectoryPoint> piece(const Trajectory& reference, std::int64_t first_ns,
                                   std::int64_t last_ns) {
  std::vector<TrajectoryPoint> points{*at(reference, first_ns)};
  std::copy_if(reference.points.begin(), reference.points.end(), std::back_inserter(points),
               [=](const auto& point) { return point.t_ns > first_ns && point.t_ns < last_ns; });
  points.push_back(*at(reference, last_ns));
  return points;
}

// d(t) = R(−ψ(t)) (p(t + 35 ms) − p(t)), each side by its own heading: no alignment enters.
std::optional<ShortTerm> short_term(const Trajectory& reference, const Trajectory& estimate,
                                    std::span<const Pair> pairs) {
  Gathered displacement;
  Gathered yaw;
  const std::int64_t last = pairs.back().estimate.t_ns;
  for (const Pair& pair : pairs) {
    const std::int64_t later = pair.estimate.t_ns + short_horizon_ns;
    if (later > last) break;
    const Pose2 d = relative(pair.estimate.pose, at(estimate, later)->pose);
    const Pose2 d_reference = relative(pair.reference.pose, at(reference, later)->pose);
    displacement.add(distance(d, d_reference));
    yaw.add(std::abs(d.yaw - d_reference.yaw));
  }
  if (displacement.count() == 0) return std::nullopt;
  return ShortTerm{displacement.spread(), yaw.spread(), displacement.count()};
}

// P in the axes of the reference: the alignment turns the map.
Eigen::Matrix3d turned(const estimator::PoseCovariance& P, double yaw) {
  Eigen::Matrix3d full;
  full << P[0], P[1], P[2],  //
      P[1], P[3], P[4],      //
      P[2], P[4], P[5];
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd{yaw}.toRotationMatrix();
  return R * full * R.transpose();
}

std::optional<double> nees(const Eigen::Matrix3d& P, const Eigen::Vector3d& e) {
  const Eigen::LLT<Eigen::Matrix3d> factor{P};
  if (factor.info() != Eigen::Success) return std::nullopt;  // not positive definite
  const Eigen::Vector3d whitened = factor.matrixL().solve(e);
  if (!whitened.allFinite()) return std::nullopt;
  return whitened.squaredNorm();
}

}  // namespace

Evaluation evaluate(const Trajectory& reference, const Trajectory& estimate, Align align) {
  const auto pairs = common_times(reference, estimate);
  Evaluation result;
  result.name = estimate.name;
  result.samples = pairs.size();
  result.first_ns = pairs.front().estimate.t_ns;
  result.last_ns = pairs.back().estimate.t_ns;
  const auto path = piece(reference, result.first_ns, result.last_ns);
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step = distance(path[i - 1].pose, path[i].pose);
    const std::int64_t gap_ns = path[i].t_ns - path[i - 1].t_ns;
    result.path_length += step;
    result.reference_gap_ns = std::max(result.reference_gap_ns, gap_ns);
    if (step > fastest_car * static_cast<double>(gap_ns) * 1e-9) ++result.reference_jumps;
  }
  result.alignment = alignment(pairs, align);

  // Both headings are unwrapped; whole turns between them are settled once, at the first time.
  const double first_yaw_error =
      result.alignment.yaw + pairs.front().estimate.pose.yaw - pairs.front().reference.pose.yaw;
  const double whole_turns =
      first_yaw_error - std::remainder(first_yaw_error, 2.0 * std::numbers::pi);

  Gathered position;
  Gathered heading;
  Gathered consistency;
  Gathered vx;
  Gathered vy;
  Gathered yaw_rate;
  for (const Pair& pair : pairs) {
    const Pose2 pose = compose(result.alignment, pair.estimate.pose);
    const Pose2& truth = pair.reference.pose;
    const Eigen::Vector3d e{pose.x - truth.x, pose.y - truth.y, pose.yaw - truth.yaw - whole_turns};
    position.add(e.head<2>().norm());
    heading.add(std::abs(e[2]));
    result.end_error = e.head<2>().norm();
    result.heading_end = e[2];
    if (estimate.has_covariance) {
      const auto value = nees(turned(pair.estimate.covariance, result.alignment.yaw), e);
      if (value) consistency.add(*value);
    }
    vx.add(std::abs(pair.estimate.motion.vx - pair.reference.motion.vx));
    vy.add(std::abs(pair.estimate.motion.vy - pair.reference.motion.vy));
    yaw_rate.add(std::abs(pair.estimate.motion.yaw_rate - pair.reference.motion.yaw_rate));
  }
  result.position = position.spread();
  result.heading = heading.spread();
  if (result.path_length > 0.0) {
    result.end_cm_per_m = 100.0 * result.end_error / result.path_length;
  }
  result.short_term = short_term(reference, estimate, pairs);
  if (consistency.count() > 0) {
    result.consistency = Consistency{consistency.spread().mean, consistency.count()};
  }
  if (reference.has_motion && estimate.has_motion) {
    result.velocity_rms = Motion{vx.spread().rms, vy.spread().rms, yaw_rate.spread().rms};
  }
  return result;
}

Trajectory aligned(const Trajectory& estimate, const Pose2& alignment) {
  Trajectory moved = estimate;
  for (TrajectoryPoint& point : moved.points) {
    point.pose = compose(alignment, point.pose);
    const Eigen::Matrix3d P = turned(point.covariance, alignment.yaw);
    point.covariance = {P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2)};
  }
  return moved;
}

}  // namespace odomd::tools
