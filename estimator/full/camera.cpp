#include "estimator/full/camera.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/full/prediction.hpp"
#include "estimator/pose.hpp"
#include "estimator/symmetric3.hpp"
#include "estimator/time.hpp"

namespace odomd::estimator::full {
namespace {

constexpr std::array<at::Index, 3> pose_states{at::x, at::y, at::yaw};

// Rejected poses agree where the way from one to the next is the filter's, give or take this.
constexpr double agreeing_share = 0.25;     // of the way
constexpr double agreeing_distance = 0.05;  // [m], and four sigmas of the poses
constexpr double agreeing_yaw = 0.1;        // [rad], likewise
// A car may have gone from one pose to the next: by the filter's way and half again, and this.
constexpr double possible_share = 1.5;
constexpr double possible_speed = 1.0;     // [m/s]
constexpr double possible_yaw_rate = 2.0;  // [rad/s]
// ... and has gone somewhere by then.
constexpr double driven_distance = 0.1;  // [m]
constexpr double driven_yaw = 0.2;       // [rad]
constexpr double longest_pause_s = 0.5;  // between two poses of one run

// How well the velocity is known after the pose turned out to be wrong.
constexpr double doubted_speed = 0.1;  // [m/s]
// For so long the wheels are: what is known best to err is a wheel that slips [s].
constexpr double wheels_doubted_s = 1.0;

/// What no tyre and no sensor is off by, and where the model would lose its sense.
void keep_scales_possible(State& state) noexcept {
  state.mean[at::stiffness_scale] = std::clamp(state.mean[at::stiffness_scale], -0.7, 2.0);
  state.mean[at::gyro_scale] = std::clamp(state.mean[at::gyro_scale], -0.5, 0.5);
  state.mean[at::wheel_scale] = std::clamp(state.mean[at::wheel_scale], -0.5, 0.5);
}

bool agree(const CameraContender& before, const Pose2& seen, const Pose2& believed,
           const std::array<double, 3>& sigma) noexcept {
  const double dx = (seen.x - before.seen.x) - (believed.x - before.believed.x);
  const double dy = (seen.y - before.seen.y) - (believed.y - before.believed.y);
  const double way = std::hypot(believed.x - before.believed.x, believed.y - before.believed.y);
  const double turn =
      wrap_angle((seen.yaw - before.seen.yaw) - (believed.yaw - before.believed.yaw));
  // Where the heading is wrong, the ways differ in direction though not in length.
  const double heading = std::abs(wrap_angle(seen.yaw - believed.yaw));
  const double noise = 4.0 * std::sqrt(2.0);
  return std::hypot(dx, dy) <= (agreeing_share + heading) * way + agreeing_distance +
                                   noise * std::hypot(sigma[0], sigma[1]) &&
         std::abs(turn) <= agreeing_yaw + noise * sigma[2];
}

/// Whether a car could have gone from one pose to the next, be the filter's velocity what it may.
bool possible(const CameraContender& before, const Pose2& seen, const Pose2& believed, double dt,
              const std::array<double, 3>& sigma) noexcept {
  const double way = std::hypot(seen.x - before.seen.x, seen.y - before.seen.y);
  const double expected =
      std::hypot(believed.x - before.believed.x, believed.y - before.believed.y);
  const double turn = wrap_angle(seen.yaw - before.seen.yaw);
  const double expected_turn = believed.yaw - before.believed.yaw;
  const double noise = 4.0 * std::sqrt(2.0);
  return way <= possible_share * expected + possible_speed * dt +
                    noise * std::hypot(sigma[0], sigma[1]) &&
         std::abs(turn) <=
             possible_share * std::abs(expected_turn) + possible_yaw_rate * dt + noise * sigma[2];
}

/// A long run of poses that a car could have come through, and has: a picture that stands still is
/// no car that slips.
bool seen_driving(const CameraContender& run) noexcept {
  return run.steady >= steady_rejections &&
         (std::hypot(run.seen.x - run.first.x, run.seen.y - run.first.y) > driven_distance ||
          std::abs(wrap_angle(run.seen.yaw - run.first.yaw)) > driven_yaw);
}

/// The pose becomes `seen`, its covariance that of the camera, and nothing else is related to it.
void move_to(State& state, const Pose2& seen, const std::array<double, 3>& sigma) noexcept {
  state.mean[at::x] = seen.x;
  state.mean[at::y] = seen.y;
  state.mean[at::yaw] = seen.yaw;
  state.covariance.topRows<3>().setZero();
  state.covariance.leftCols<3>().setZero();
  for (std::size_t i = 0; i < pose_states.size(); ++i) {
    state.covariance(pose_states[i], pose_states[i]) = sigma[i] * sigma[i];
  }
}

}  // namespace

Judgement take_camera(const CameraGate& gate, State& state, const Sample& sample) noexcept {
  Judgement judgement{.source = Source::camera, .verdict = Verdict::fused, .degrees = 0};
  const auto& [z_x, z_y, z_yaw] = sample.value;
  const auto fused = [&] {
    state.fused_ns[static_cast<std::size_t>(Source::camera)] = sample.time_ns;
    state.contender = {};
  };
  if (!state.located) {
    if (!gate.locates) {
      judgement.verdict = Verdict::source_off;
      return judgement;
    }
    move_to(state, {z_x, z_y, wrap_angle(z_yaw)}, sample.sigma);
    state.located = true;
    fused();
    return judgement;
  }

  const Pose2 believed = state.pose();
  judgement.degrees = 3;
  judgement.innovation = {z_x - believed.x, z_y - believed.y, wrap_angle(z_yaw - believed.yaw)};
  const auto& P = state.covariance;
  const Symmetric3 S{P(0, 0) + sample.sigma[0] * sample.sigma[0],
                     P(0, 1),
                     P(0, 2),
                     P(1, 1) + sample.sigma[1] * sample.sigma[1],
                     P(1, 2),
                     P(2, 2) + sample.sigma[2] * sample.sigma[2]};
  judgement.variance = {S[0], S[3], S[5]};
  judgement.squared_ratio = mahalanobis_squared(S, judgement.innovation);
  judgement.test_ratio = judgement.squared_ratio / gate.gate;
  state.camera_test_ratio = judgement.test_ratio;

  // The turn that continues the filter's yaw.
  const Pose2 seen{z_x, z_y, believed.yaw + judgement.innovation[2]};
  if (judgement.squared_ratio <= gate.gate) {
    const std::array<double, 3> measured{seen.x, seen.y, seen.yaw};
    for (std::size_t i = 0; i < pose_states.size(); ++i) {
      Prediction z;
      z.value = state.mean[pose_states[i]];
      z.variance = sample.sigma[i] * sample.sigma[i];
      z.depends_on(pose_states[i], 1.0);
      const Innovation nu = full::innovation(state, z, measured[i]);
      correct(state, nu, optimal_gain(nu));
    }
    keep_scales_possible(state);
    fused();
    return judgement;
  }

  const CameraContender& before = state.contender;
  const double dt = seconds_between(before.capture_ns, sample.time_ns);
  const bool goes_on = before.steady > 0 && dt <= longest_pause_s;
  const bool steady = goes_on && possible(before, seen, believed, dt, sample.sigma);
  const bool agrees = goes_on && agree(before, seen, believed, sample.sigma);
  state.contender = {.agreeing = agrees ? before.agreeing + 1 : 1,
                     .steady = steady ? before.steady + 1 : 1,
                     .first = steady ? before.first : seen,
                     .capture_ns = sample.time_ns,
                     .seen = seen,
                     .believed = believed};
  if (state.contender.agreeing < agreeing_rejections && !seen_driving(state.contender)) {
    judgement.verdict = Verdict::gated;
    return judgement;
  }
  // Believed against the test: it does not count among those that the filter expects.
  judgement.degrees = 0;
  move_to(state, seen, sample.sigma);
  state.covariance(at::v_x, at::v_x) += doubted_speed * doubted_speed;
  state.covariance(at::v_y, at::v_y) += doubted_speed * doubted_speed;
  state.wheels_doubted_until_ns =
      ns_after(sample.time_ns, std::llround(wheels_doubted_s * ns_per_second));
  ++state.resets;
  state.last_jump = {seen.x - believed.x, seen.y - believed.y, seen.yaw - believed.yaw};
  fused();
  return judgement;
}

}  // namespace odomd::estimator::full
