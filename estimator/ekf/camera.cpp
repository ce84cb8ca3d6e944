// docs/model.md, "Camera".
#include "estimator/ekf/camera.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/noise.hpp"
#include "estimator/ekf/standstill.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {
namespace {

// Below this noise scale the stated noise is used.
constexpr double least_camera_noise_scale = 2.5;

constexpr std::array<at::Index, 3> pose_states{at::x, at::y, at::yaw};

constexpr double longest_pause_s = 0.5;  // between two poses of a run

// Uncertainty of the motion after a reset, at least and at most.
constexpr double reset_speed_sigma = 0.1;  // [m/s]
constexpr double largest_reset_speed_sigma = 1.0;
constexpr double reset_bias_sigma = 0.03;  // [rad/s], of the gyro
constexpr double largest_reset_bias_sigma = 0.1;

/// Limits of the slow errors, within which the model holds.
void clamp_scales(State& state) noexcept {
  SlowVector& scales = state.slow.mean;
  const auto keep = [&scales](slow::Index index, double lowest, double highest) {
    scales[index] = std::clamp(scales[index], lowest, highest);
  };
  keep(slow::stiffness_scale, -0.7, 2.0);
  keep(slow::gyro_scale, -0.5, 0.5);
  keep(slow::wheel_scale, -0.5, 0.5);
}

double distance(const Pose2& a, const Pose2& b) noexcept {
  return std::hypot(b.x - a.x, b.y - a.y);
}

/// Measured minus estimated motion from one pose to the other, in the filter's axes. An error of
/// the heading does not change it.
Pose2 step_difference(const PosePair& before, const PosePair& now) noexcept {
  const double heading = before.measured.yaw - before.estimated.yaw;
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  const double x = now.measured.x - before.measured.x;
  const double y = now.measured.y - before.measured.y;
  return {c * x + s * y - (now.estimated.x - before.estimated.x),
          c * y - s * x - (now.estimated.y - before.estimated.y),
          wrap_angle(now.measured.yaw - before.measured.yaw -
                     (now.estimated.yaw - before.estimated.yaw))};
}

double chi_squared(const Pose2& difference, const std::array<double, 3>& sigma,
                   double allowed_way = 0.0, double allowed_turn = 0.0) noexcept {
  const double way = sigma[0] * sigma[0] + sigma[1] * sigma[1] + allowed_way * allowed_way;
  const double turn = 2.0 * sigma[2] * sigma[2] + allowed_turn * allowed_turn;
  return (difference.x * difference.x + difference.y * difference.y) / way +
         difference.yaw * difference.yaw / turn;
}

/// Whether camera and filter saw the same motion from one pose to the other. Of the way of a car
/// that slides the filter knows little: there the camera must only have moved.
bool is_same_motion(const PosePair& from, const PosePair& to, const std::array<double, 3>& sigma,
                    bool slides) noexcept {
  constexpr double share = 0.1;  // error of the filter's motion
  const double turn = share * distance(from.estimated, to.estimated);
  const double way = slides ? std::max(turn, distance(from.measured, to.measured)) : turn;
  return chi_squared(step_difference(from, to), sigma, way, turn) <= CameraGate{}.gate;
}

/// Whether the car has moved so far that a frozen camera would be detected.
bool has_moved_enough(const State& state, const PosePair& from,
                      const std::array<double, 3>& sigma) noexcept {
  constexpr double sigmas = 8.0;
  return state.standstill.standing ||
         distance(from.estimated, state.pose()) >= sigmas * std::hypot(sigma[0], sigma[1]);
}

/// Sets the pose and its covariance to those of the camera, without correlations.
void move_to(State& state, const Pose2& measured, const std::array<double, 3>& sigma) noexcept {
  state.mean.head<3>() << measured.x, measured.y, measured.yaw;
  for (std::size_t i = 0; i < pose_states.size(); ++i) {
    forget(state, pose_states[i], sigma[i]);
  }
}

}  // namespace

/// The step error's change n_k - 2 n_k-1 + n_k-2 has six times the variance of one pose. The scale
/// tracks its median, which for χ² with three degrees of freedom is 2.37: robust against outliers.
void note_camera_pose(State& state, const Sample& pose) noexcept {
  constexpr double median = 2.37;
  constexpr double step = 1.16;
  constexpr double most = 100.0;
  const auto& [x, y, yaw] = pose.value;
  const PosePair before = std::exchange(
      state.last_camera_pose,
      {.capture_ns = pose.time_ns, .measured = {x, y, yaw}, .estimated = state.pose()});
  if (before.capture_ns == 0 ||
      seconds_between(before.capture_ns, pose.time_ns) > longest_pause_s) {
    return;
  }
  PosePair& now = state.last_camera_pose;
  now.step_error = step_difference(before, now);
  now.has_step = true;
  if (!before.has_step) {
    return;
  }
  const Pose2 scatter{now.step_error.x - before.step_error.x,
                      now.step_error.y - before.step_error.y,
                      now.step_error.yaw - before.step_error.yaw};
  double& noise_scale = state.camera_noise_scale;
  const double ratio = chi_squared(scatter, pose.sigma) / 3.0;
  noise_scale =
      std::clamp(ratio > median * noise_scale ? noise_scale * step : noise_scale / step, 1.0, most);
}

Judgement take_camera(const CarModel& model, const CameraGate& gate, State& state,
                      const Sample& stated) noexcept {
  Sample sample = stated;
  Judgement judgement{.source = Source::camera, .verdict = Verdict::fused, .degrees = 0};
  const auto& [z_x, z_y, z_yaw] = sample.value;
  const auto fused = [&] {
    state.fused_ns[index_of(Source::camera)] = sample.time_ns;
    state.rejected_poses = 0;
    state.camera_was_distrusted = false;
    state.turned_since_ns = 0;
    state.confirming_poses = std::min(state.confirming_poses + 1, rejections_to_accept);
    if (state.confirming_poses == rejections_to_accept) {
      state.doubtful = false;
    }
    state.last_camera_pose.estimated = state.pose();
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

  const Pose2 estimated = state.pose();
  if (state.camera_noise_scale > least_camera_noise_scale) {
    for (double& sigma : sample.sigma) {
      sigma *= std::sqrt(state.camera_noise_scale);
    }
  }
  judgement.degrees = 3;
  judgement.innovation = {z_x - estimated.x, z_y - estimated.y, wrap_angle(z_yaw - estimated.yaw)};
  const Eigen::Matrix<double, 6, 6> P = covariance_of_motion(state);
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

  // The yaw nearest to the filter's, of all turns.
  const Pose2 measured{z_x, z_y, estimated.yaw + judgement.innovation[2]};
  if (judgement.squared_ratio <= gate.gate) {
    const std::array<double, 3> values{measured.x, measured.y, measured.yaw};
    for (std::size_t i = 0; i < pose_states.size(); ++i) {
      Prediction z;
      z.value = state.mean[pose_states[i]];
      z.variance = sample.sigma[i] * sample.sigma[i];
      z.depends_on(pose_states[i], 1.0);
      const Innovation nu = full::innovation(state, z, values[i]);
      correct(state, nu, optimal_gain(nu));
      correct_slow_errors(state, nu, all());
    }
    clamp_scales(state);
    const std::int64_t before_ns = state.fused_ns[index_of(Source::camera)];
    if (before_ns != 0) {
      adapt_way_noise_scale(model.tuning, state, judgement.squared_ratio,
                            seconds_between(before_ns, sample.time_ns));
    }
    fused();
    return judgement;
  }

  state.confirming_poses = 0;
  if (!state.integrity.agrees(Source::camera) ||
      !is_same_motion(state.first_rejected, state.last_camera_pose, sample.sigma,
                      state.integrity.slides())) {
    state.rejected_poses = 0;
  }
  if (state.rejected_poses++ == 0) {
    state.first_rejected = state.last_camera_pose;
  }
  if (state.rejected_poses < rejections_to_accept ||
      seconds_between(state.first_rejected.capture_ns, sample.time_ns) < rejection_timeout_s ||
      !has_moved_enough(state, state.first_rejected, sample.sigma)) {
    judgement.verdict = Verdict::gated;
    return judgement;
  }
  // A camera that was distrusted does not reset a pose that is not doubtful; but one of both is
  // wrong.
  if (state.camera_was_distrusted && !state.doubtful) {
    state.doubtful = state.disputed = true;
    judgement.verdict = Verdict::gated;
    return judgement;
  }
  // Fused against the test, so it does not enter the filter's statistics.
  judgement.degrees = 0;
  judgement.verdict = Verdict::forced;
  if (state.standstill.standing) {
    set_off(model, state, 0.0);
  }
  // The first fused pose initialises; later either of both may be wrong.
  state.disputed =
      state.disputed || (state.fused_ns[index_of(Source::camera)] != 0 && !state.doubtful);
  const double since_fused_s =
      seconds_between(state.fused_ns[index_of(Source::camera)], sample.time_ns);
  move_to(state, measured, sample.sigma);
  // The jump has come from an error of the motion since the last fused pose.
  const auto inflation = [&](double jump, double least, double most) {
    const double rate = jump / std::max(since_fused_s, rejection_timeout_s);
    return std::min(least * least + rate * rate, most * most);
  };
  const double way = std::hypot(measured.x - estimated.x, measured.y - estimated.y);
  state.covariance(at::v_x, at::v_x) +=
      inflation(way, reset_speed_sigma, largest_reset_speed_sigma);
  state.slow.covariance(slow::gyro_bias, slow::gyro_bias) +=
      inflation(measured.yaw - estimated.yaw, reset_bias_sigma, largest_reset_bias_sigma);
  ++state.resets;
  state.last_jump = {measured.x - estimated.x, measured.y - estimated.y,
                     measured.yaw - estimated.yaw};
  fused();
  return judgement;
}

}  // namespace odomd::estimator::full
