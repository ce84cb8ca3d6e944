#include "tools/evaluation/pose_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include <Eigen/Dense>

#include "estimator/common/symmetric3.hpp"
#include "tools/cli/csv.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {
namespace {

using estimator::Pose2;

std::string span_of(const Trajectory& trajectory) {
  std::string text = trajectory.name + " spans t = ";
  append_seconds(text, trajectory.points.front().t_ns);
  text += " to ";
  append_seconds(text, trajectory.points.back().t_ns);
  return text;
}

// Least squares over positions (Umeyama 1991, eqs 40-43, without scale): with p and q reduced by
// their means, the rotation angle is atan2(Σ p × q, Σ p · q).
Pose2 least_squares(std::span<const Pair> pairs) {
  const auto count = static_cast<double>(pairs.size());
  Pose2 mean_estimate;
  Pose2 mean_reference;
  for (const Pair& pair : pairs) {
    mean_estimate.x += pair.estimate.pose.x / count;
    mean_estimate.y += pair.estimate.pose.y / count;
    mean_reference.x += pair.reference.pose.x / count;
    mean_reference.y += pair.reference.pose.y / count;
  }
  double dot = 0.0, cross = 0.0;
  double yaw_cos = 0.0, yaw_sin = 0.0;
  for (const Pair& pair : pairs) {
    const double px = pair.estimate.pose.x - mean_estimate.x;
    const double py = pair.estimate.pose.y - mean_estimate.y;
    const double qx = pair.reference.pose.x - mean_reference.x;
    const double qy = pair.reference.pose.y - mean_reference.y;
    dot += px * qx + py * qy;
    cross += px * qy - py * qx;
    const double turn = pair.reference.pose.yaw - pair.estimate.pose.yaw;
    yaw_cos += std::cos(turn);
    yaw_sin += std::sin(turn);
  }
  // A stationary car's positions have no spread: only headings determine the rotation.
  constexpr double least_spread = 1e-6;  // m²
  const bool spread = std::hypot(dot, cross) > least_spread * count;
  const double yaw = spread ? std::atan2(cross, dot) : std::atan2(yaw_sin, yaw_cos);
  const Pose2 turned = compose({0.0, 0.0, yaw}, mean_estimate);
  return {mean_reference.x - turned.x, mean_reference.y - turned.y, yaw};
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

std::vector<Pair> common_times(const Trajectory& reference, const Trajectory& estimate) {
  std::vector<Pair> pairs;
  for (const TrajectoryPoint& point : estimate.points) {
    auto there = at(reference, point.t_ns);
    if (!there) continue;
    if (!reference.is_camera) there->covariance = {};
    pairs.push_back({point, *there});
  }
  if (pairs.size() < 2) {
    throw std::invalid_argument(span_of(estimate) + ", " + span_of(reference) +
                                ": fewer than two common times; put both on the log's clock");
  }
  return pairs;
}

Pose2 alignment(std::span<const Pair> pairs, Align align) {
  switch (align) {
    case Align::first:
      return compose(pairs.front().reference.pose, inverse(pairs.front().estimate.pose));
    case Align::fit:
      return least_squares(pairs);
    case Align::none:
      break;
  }
  return {};
}

Trajectory at_centre_of_gravity(const Trajectory& reference, const Pose2& lever_arm) {
  const Pose2 back = inverse(lever_arm);
  const double c = std::cos(lever_arm.yaw);
  const double s = std::sin(lever_arm.yaw);
  Trajectory moved = reference;
  for (TrajectoryPoint& point : moved.points) {
    point.pose = compose(point.pose, back);
    // v_cog = R(lever yaw) v_point − ψ̇ × lever
    const estimator::BodyVelocity v = point.motion;
    point.motion.v_x = c * v.v_x - s * v.v_y + v.yaw_rate * lever_arm.y;
    point.motion.v_y = s * v.v_x + c * v.v_y - v.yaw_rate * lever_arm.x;
  }
  return moved;
}

LeverArmFit fit_lever_arm(const Trajectory& reference, std::span<const Trajectory> estimates) {
  constexpr std::int64_t window_ns = 1'000'000'000;
  constexpr std::int64_t stride_ns = 100'000'000;

  // While the centre of gravity moves by d, a point at l with heading γ in the body frame moves by
  // d_point, in its own axes:  k R(γ) d_point − (R(Δψ) − I) k l = k d,  where k d is the
  // displacement of an estimate with scale factor k. Linear in u = k (cos γ, sin γ, l_x, l_y).
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double moved = 0.0;
  double turned = 0.0;
  LeverArmFit fit;
  for (const Trajectory& estimate : estimates) {
    const auto pairs = common_times(reference, estimate);
    const std::int64_t end = pairs.back().estimate.t_ns;
    for (std::int64_t t = pairs.front().estimate.t_ns; t + window_ns <= end; t += stride_ns) {
      const auto before = at(reference, t);
      const auto after = at(reference, t + window_ns);
      if (!before || !after) continue;  // a gap of the reference
      const Pose2 d = relative(at(estimate, t)->pose, at(estimate, t + window_ns)->pose);
      const Pose2 d_point = relative(before->pose, after->pose);
      const double c = std::cos(d_point.yaw) - 1.0;
      const double s = std::sin(d_point.yaw);
      Eigen::Matrix<double, 2, 4> A;
      A << d_point.x, -d_point.y, -c, s,  //
          d_point.y, d_point.x, -s, -c;
      normal += A.transpose() * A;
      right += A.transpose() * Eigen::Vector2d{d.x, d.y};
      moved += d_point.x * d_point.x + d_point.y * d_point.y;
      turned += c * c + s * s;
      ++fit.windows;
    }
  }
  const auto count = static_cast<double>(fit.windows);
  constexpr double least_moved = 0.05;   // m in a second, rms
  constexpr double least_turned = 0.05;  // rad in a second, rms
  if (fit.windows < 10 || std::sqrt(moved / count) < least_moved ||
      std::sqrt(turned / count) < least_turned) {
    throw std::invalid_argument(reference.name +
                                ": the drive is too short or turns too little to fit a lever arm; "
                                "give it with --lever-arm x,y,yaw");
  }
  const Eigen::Vector4d u = normal.ldlt().solve(right);
  const double k = std::hypot(u[0], u[1]);
  if (!(k > 0.1) || !u.allFinite()) {
    throw std::invalid_argument(reference.name +
                                ": reference and estimate move too differently to fit a lever "
                                "arm; give it with --lever-arm x,y,yaw");
  }
  fit.lever_arm = {u[2] / k, u[3] / k, std::atan2(u[1], u[0])};
  return fit;
}

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
      e.covariance = estimator::rotated(pair.estimate.covariance, c, s);  // to the reference's axes
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
    Gathered displacement, yaw;
    for (const Pair& pair : pairs) {
      const std::int64_t later_ns = pair.estimate.t_ns + horizon_ns;
      if (later_ns > pairs.back().estimate.t_ns) break;
      const auto there = at(estimate, later_ns), true_there = at(reference, later_ns);
      if (!there || !true_there) continue;
      const Pose2 d = relative(pair.estimate.pose, there->pose);
      const Pose2 d_true = relative(pair.reference.pose, true_there->pose);
      displacement.add(std::hypot(d_true.x - d.x, d_true.y - d.y));
      yaw.add(std::abs(d.yaw - d_true.yaw));
    }
    if (displacement.count() > 0)
      errors.push_back({horizon_ns, displacement.spread(), yaw.spread(), displacement.count()});
  }
  return errors;
}

}  // namespace odomd::tools
