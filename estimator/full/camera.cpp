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
constexpr double longest_pause_s = 0.5;     // between two poses of one run

// How well the velocity is known after the pose turned out to be wrong.
constexpr double doubted_speed = 0.1;  // [m/s]

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
  Judgement judgement{.source = Source::camera, .verdict = Verdict::fused, .degrees = 3};
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
  judgement.innovation = {z_x - believed.x, z_y - believed.y, wrap_angle(z_yaw - believed.yaw)};
  const auto& P = state.covariance;
  const Symmetric3 S{P(0, 0) + sample.sigma[0] * sample.sigma[0],
                     P(0, 1),
                     P(0, 2),
                     P(1, 1) + sample.sigma[1] * sample.sigma[1],
                     P(1, 2),
                     P(2, 2) + sample.sigma[2] * sample.sigma[2]};
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
  const bool goes_on = before.agreeing > 0 &&
                       seconds_between(before.capture_ns, sample.time_ns) <= longest_pause_s &&
                       agree(before, seen, believed, sample.sigma);
  state.contender = {goes_on ? before.agreeing + 1 : 1, sample.time_ns, seen, believed};
  if (state.contender.agreeing < agreeing_rejections) {
    judgement.verdict = Verdict::gated;
    return judgement;
  }
  move_to(state, seen, sample.sigma);
  state.covariance(at::v_x, at::v_x) += doubted_speed * doubted_speed;
  state.covariance(at::v_y, at::v_y) += doubted_speed * doubted_speed;
  ++state.resets;
  state.last_jump = {seen.x - believed.x, seen.y - believed.y, seen.yaw - believed.yaw};
  fused();
  return judgement;
}

}  // namespace odomd::estimator::full
