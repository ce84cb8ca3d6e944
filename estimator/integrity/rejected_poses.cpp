#include "estimator/integrity/rejected_poses.hpp"

#include <cmath>

#include "estimator/common/time.hpp"

namespace odomd::estimator {
namespace {

constexpr double suspect_share = 0.5;
constexpr double suspect_speed = 0.5;     // [m/s]
constexpr double suspect_yaw_rate = 1.0;  // [rad/s]
constexpr double longest_pause_s = 0.5;

}  // namespace

Symmetric3 suspect_motion(const Pose2& from, const Pose2& to, double dt) noexcept {
  const double distance = std::hypot(to.x - from.x, to.y - from.y);
  const double position = suspect_share * distance + suspect_speed * dt;
  const double yaw = suspect_share * std::abs(to.yaw - from.yaw) + suspect_yaw_rate * dt;
  return diagonal(position * position, position * position, yaw * yaw);
}

bool agree(RejectedRun& run, const RejectedPose& next, double gate) noexcept {
  const RejectedRun before = run;
  run = {1, next};
  const RejectedPose& last = before.last;
  const double dt = seconds_between(last.capture_ns, next.capture_ns);
  if (before.agreeing == 0 || dt <= 0.0 || dt > longest_pause_s) {
    return false;
  }
  // ν = camera - (the one before, moved on by the odometry), S = both covariances and the
  // odometry's
  const Pose2 expected = compose(frame_of(last.map, last.odom), next.odom);
  const Symmetric3 S =
      sum(sum(displaced(last.covariance, expected.x - last.map.x, expected.y - last.map.y),
              next.covariance),
          suspect_motion(last.odom, next.odom, dt));
  if (mahalanobis_squared(S, difference(next.map, expected)) <= gate) {
    run.agreeing = before.agreeing + 1;
  }
  return run.agreeing >= agreeing_rejections;
}

}  // namespace odomd::estimator
