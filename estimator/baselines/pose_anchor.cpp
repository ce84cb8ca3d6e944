#include "estimator/baselines/pose_anchor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "estimator/common/predecessor.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator {
namespace {

// Beyond a deviation of a kilometre or half a turn the pose counts as unknown.
const Eigen::Vector3d largest_deviation(largest_camera_sigma, largest_camera_sigma,
                                        std::numbers::pi);

// A pause ends a run of rejected poses. An accepted run makes the odometry suspect for a while.
constexpr double longest_pause_s = 0.5;
constexpr double suspect_s = 2.0;
constexpr double suspect_share = 0.5;
constexpr double suspect_speed = 0.5;     // [m/s]
constexpr double suspect_yaw_rate = 1.0;  // [rad/s]

Eigen::Matrix3d rotation(double yaw) noexcept {
  return estimator::rotation(std::cos(yaw), std::sin(yaw));
}

/// F for the displacement between two odometry poses, in a frame rotated by R.
Eigen::Matrix3d displacement(const Pose2& from, const Pose2& to,
                             const Eigen::Matrix3d& R) noexcept {
  const Eigen::Vector3d way = R * Eigen::Vector3d(to.x - from.x, to.y - from.y, 0.0);
  return estimator::displacement(way[0], way[1]);
}

/// P ← F P Fᵀ + R Q Rᵀ, exactly symmetric.
Eigen::Matrix3d grown(const Eigen::Matrix3d& P, const Eigen::Matrix3d& F, const Eigen::Matrix3d& R,
                      const Eigen::Matrix3d& noise) noexcept {
  Eigen::Matrix3d next = F * P * F.transpose() + R * noise * R.transpose();
  next.diagonal() *= rounding_inflation;
  limit(next, largest_deviation);
  return next.selfadjointView<Eigen::Upper>();
}

/// Variances of suspect odometry between two poses; σ grows linearly with motion and time.
Eigen::Vector3d suspect_motion(const Pose2& from, const Pose2& to, double dt) noexcept {
  const double way = std::hypot(to.x - from.x, to.y - from.y);
  const double position = suspect_share * way + suspect_speed * dt;
  const double yaw = suspect_share * std::abs(to.yaw - from.yaw) + suspect_yaw_rate * dt;
  return Eigen::Vector3d(position, position, yaw).cwiseAbs2();
}

}  // namespace

PoseAnchor::PoseAnchor(const FilterSettings& settings) noexcept : settings_(settings) {
  tick(0).covariance = white_;
}

void PoseAnchor::set_pose(const Pose2& pose) noexcept {
  re_anchor({odom(), last_, 0.0}, pose, squared(initial_sigma) * Eigen::Matrix3d::Identity());
  tick(last_).covariance = white_ = squared(initial_sigma) * Eigen::Matrix3d::Identity();
}

void PoseAnchor::resume(const Estimate& predecessor) noexcept {
  *this = PoseAnchor(settings_);
  tick(0).odom = predecessor.odom;
  tick(0).covariance = white_ = unpacked(predecessor.covariance);
  map_from_odom_ = frame_of(predecessor.map, predecessor.odom);
  initialised_ = true;
  reset_count_ = predecessor.reset_count + 1;
}

void PoseAnchor::extend(std::int64_t time_ns, const Motion& motion) noexcept {
  const double dt = settings_.period_s;
  if (!started()) {
    tick(0).time_ns = ns_after(time_ns, -std::llround(dt * ns_per_second));
  }
  const Tick& before = tick(last_);
  Tick& now = tick(++last_);
  now.time_ns = time_ns;
  now.odom = compose(before.odom, motion.way);
  now.velocity = motion.mean;
  // Q = Δt² G V Gᵀ
  const double yaw = before.odom.yaw;
  const Eigen::Matrix3d G = rotation(yaw);
  now.noise = dt * dt * (G * unpacked(motion.covariance) * G.transpose());
  const double gap_s = seconds_between(before.time_ns, time_ns) - dt;
  if (gap_s >= dt) {
    now.noise.diagonal() += gap_noise(0.5 * gap_s * gap_s);
  }
  if (time_ns <= suspect_until_ns_) {
    // n ticks after the last camera pose, σ is n σ_1, so tick n adds σ_1² (2n - 1).
    const double n = std::clamp(seconds_between(fused_capture_ns_, time_ns) / dt, 1.0, 40.0);
    now.noise.diagonal() += (2.0 * n - 1.0) * suspect_motion(before.odom, now.odom, dt);
  }
  now.by_errors = dt * G * motion.sensitivity;
  // Learning an error does not correct past poses: the error's effect so far moves to white_.
  if (const Eigen::Vector3d learnt = error_variance_ - motion.error_variance;
      learnt.maxCoeff() > 0.0) {
    white_ += by_errors(sensitivity_, learnt.cwiseMax(0.0));
  }
  error_variance_ = motion.error_variance;
  grow(before.odom, now, 1.0);
}

Verdict PoseAnchor::take(const CameraPose& camera, std::int64_t latest_ns,
                         std::int64_t arrival_ns) noexcept {
  const std::int64_t time_ns = camera.capture_ns;
  if (!is_usable(camera)) {
    return Verdict::non_finite;
  }
  if (time_ns > latest_ns) {
    return Verdict::future;
  }
  // Before the first tick, a newer pose initialises again.
  const bool initialises = !initialised_ || (!started() && fused_capture_ns_ != 0);
  const bool remembered = started() && time_ns >= tick(oldest()).time_ns;
  if (seconds_between(time_ns, arrival_ns) > settings_.camera_max_latency_s ||
      (fused_capture_ns_ != 0 && time_ns < fused_capture_ns_) ||
      !(remembered || (initialises && oldest() == 0))) {
    return Verdict::too_old;
  }
  if (time_ns == judged_capture_ns_ && time_ns != 0) {
    return Verdict::duplicate;
  }
  if (std::abs(camera.x) > largest_coordinate || std::abs(camera.y) > largest_coordinate) {
    return Verdict::gated;
  }
  if (!initialised_ && !settings_.initialise_from_camera) {
    return Verdict::source_off;
  }

  judged_capture_ns_ = time_ns;
  const Place at = place(time_ns);
  const auto bounded = [](double sigma) { return bounded_sigma(sigma, largest_camera_sigma); };
  const Eigen::Vector3d R =
      Eigen::Vector3d(bounded(camera.sigma_x), bounded(camera.sigma_y), bounded(camera.sigma_yaw))
          .cwiseAbs2();
  Pose2 seen{camera.x, camera.y, wrap_angle(camera.yaw)};
  if (initialises) {
    initialised_ = false;
    reset_count_ = 0;
  } else {
    // P at the capture time, from P at the next tick
    const Tick& next = tick(at.next);
    const Eigen::Matrix3d turn = rotation(map_from_odom_.yaw);
    Eigen::Matrix3d S =
        grown(next.covariance, displacement(next.odom, at.odom, turn), turn, at.steps * next.noise);
    // ν = camera - map(t_capture),  S = P(t_capture) + R,  νᵀS⁻¹ν <= gate
    S.diagonal() += R;
    const Pose2 estimated = compose(map_from_odom_, at.odom);
    const std::array<double, 3> nu = difference(seen, estimated);
    const double squared_ratio = mahalanobis_squared(S, nu);
    test_ratio_ = squared_ratio / settings_.camera_gate;
    // Unwraps the measured yaw to the equivalent angle nearest to the map yaw.
    seen.yaw = estimated.yaw + nu[2];
    if (!(squared_ratio <= settings_.camera_gate)) {
      if (!accepts_run({time_ns, seen, at.odom, R})) {
        return Verdict::gated;
      }
      suspect_until_ns_ = ns_after(tick(last_).time_ns, std::llround(suspect_s * ns_per_second));
    }
  }
  re_anchor(at, seen, R.asDiagonal());
  fused_capture_ns_ = time_ns;
  return Verdict::fused;
}

/// The odometry pose at a time: on the arc to the first tick at or after that time. Outside the
/// stored ticks, the first or the last arc is extrapolated.
PoseAnchor::Place PoseAnchor::place(std::int64_t time_ns) const noexcept {
  std::size_t next = last_;
  while (next > oldest() + 1 && tick(next - 1).time_ns >= time_ns) {
    --next;
  }
  const double dt = seconds_between(tick(next).time_ns, time_ns);
  return {moved(tick(next).odom, tick(next).velocity, dt), next, std::abs(dt) / settings_.period_s};
}

/// Adds a rejected pose to the run. Returns whether the run is now long enough to be accepted: many
/// poses that agree with each other but not with the odometry, as when wheels spin or lock.
bool PoseAnchor::accepts_run(const RejectedPose& rejected) noexcept {
  const RejectedPose last = std::exchange(last_rejected_, rejected);
  const double dt = seconds_between(last.capture_ns, rejected.capture_ns);
  // ν = camera - (the previous rejected pose, moved by the odometry); S is the sum of the
  // covariances of both poses and of the odometry
  const Pose2 expected = compose(frame_of(last.map, last.odom), rejected.odom);
  const Eigen::Matrix3d S =
      (last.variance + rejected.variance + suspect_motion(last.odom, rejected.odom, dt))
          .asDiagonal();
  const bool agrees =
      dt > 0.0 && dt <= longest_pause_s &&
      mahalanobis_squared(S, difference(rejected.map, expected)) <= settings_.camera_gate;
  rejected_in_a_row_ = agrees ? rejected_in_a_row_ + 1 : 1;
  return rejected_in_a_row_ >= rejections_to_accept;
}

/// Propagates the covariance of the map pose to a tick, and stores it there.
void PoseAnchor::grow(const Pose2& from, Tick& to, double steps) noexcept {
  const Eigen::Matrix3d R = rotation(map_from_odom_.yaw);
  const Eigen::Matrix3d F = displacement(from, to.odom, R);
  to.covariance = white_ = grown(white_, F, R, steps * to.noise);
  if (error_variance_.isZero(0.0)) {
    return;
  }
  // B ← F B + Δt G ∂velocity / ∂errors,  P = P_white + B D Bᵀ
  sensitivity_ = F * sensitivity_ + steps * R * to.by_errors;
  to.covariance += by_errors(sensitivity_, error_variance_);
  limit(to.covariance, largest_deviation);
}

/// Sets the map pose at `at` to `map`, and propagates its covariance from there to the newest tick.
/// The first call also moves the odometry frame, which has not been published yet.
void PoseAnchor::re_anchor(Place at, const Pose2& map, const Eigen::Matrix3d& covariance) noexcept {
  const Pose2 before = this->map();
  if (!initialised_) {
    const Pose2 shift = frame_of(map, at.odom);
    const Eigen::Matrix3d R = rotation(shift.yaw);
    for (Tick& tick : ring_) {
      tick.odom = compose(shift, tick.odom);
      tick.noise = R * tick.noise * R.transpose();
      tick.by_errors = R * tick.by_errors;
    }
    at.odom = map;
  }
  map_from_odom_ = frame_of(map, at.odom);

  white_ = covariance;
  sensitivity_.setZero();
  for (std::size_t k = at.next; k <= last_; ++k) {
    grow(at.odom, tick(k), at.steps);
    at = {tick(k).odom, k, 1.0};
  }

  last_jump_ = initialised_ ? this->map() - before : Pose2{};
  ++reset_count_;
  rejected_in_a_row_ = 0;
  initialised_ = true;
}

}  // namespace odomd::estimator
