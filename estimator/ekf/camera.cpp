// docs/model.md, "Camera".
#include "estimator/ekf/take.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/judge.hpp"
#include "estimator/ekf/standstill.hpp"
#include "estimator/ekf/update.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator::full {
namespace {

// Below this noise scale the stated noise is used.
constexpr double least_camera_noise_scale = 2.5;

// Shortest time over which a difference is attributed to a wrong velocity [s].
constexpr double shortest_drift_s = 0.03;

constexpr std::array<at::Index, 3> pose_states{at::x, at::y, at::yaw};

// Longest time between two poses whose difference is attributed to the camera's noise [s].
constexpr double longest_pause_s = 0.5;

double distance(const Pose2& a, const Pose2& b) noexcept {
  return std::hypot(b.x - a.x, b.y - a.y);
}

/// Measured minus estimated motion from one pose to the other, in the filter's axes. A heading
/// error does not change this difference.
Pose2 step_difference(const PosePair& before, const PosePair& now) noexcept {
  const double heading = before.measured.yaw - before.estimated.yaw;
  Pose2 step = compose({0.0, 0.0, -heading}, now.measured - before.measured) -
               (now.estimated - before.estimated);
  step.yaw = wrap_angle(step.yaw + heading);
  return step;
}

/// Log density of a step between two poses of this sigma; `way`, `turn`: additional sigmas of the
/// displacement and of the turn.
double log_density(const Pose2& step, const std::array<double, 3>& sigma, double way, double turn) {
  const double of_way = squared(sigma[0]) + squared(sigma[1]) + squared(way);
  const double of_turn = 2.0 * squared(sigma[2]) + squared(turn);
  return -0.5 * ((squared(step.x) + squared(step.y)) / of_way + squared(step.yaw) / of_turn +
                 std::log(squared(of_way) * of_turn));
}

/// Evidence of the step between two camera poses: log p(step | the car moves like the filter, but
/// elsewhere) - log p(step | outliers, or a tracker that stands still). The filter knows a sliding
/// car's heading, but hardly the distance it covers; `yaw_ratio` is the heading's ν²/S.
double evidence_of_step(const CarModel& model, const State& state, const PosePair& before,
                        const std::array<double, 3>& sigma, double yaw_ratio) noexcept {
  const Tuning& tuning = model.tuning;
  const PosePair& now = state.last_camera_pose;
  const Pose2 seen = now.seen;
  const double turn = tuning.motion_error * distance(before.estimated, now.estimated);
  const double like_filter = log_density(now.step_error, sigma, turn, turn);
  // A sliding car may also keep the velocity seen by the camera and turn as the filter predicts.
  const double dt = seconds_between(before.capture_ns, now.capture_ns);
  const double again = dt / before.seen_s;
  const double way = std::hypot(gravity * dt * dt, 2.0 * again * std::hypot(sigma[0], sigma[1]));
  const double goes_on = before.seen_s > 0.0
                             ? log_density({seen.x - again * before.seen.x,
                                            seen.y - again * before.seen.y, now.step_error.yaw},
                                           sigma, way, turn) -
                                   tuning.velocity_odds - 0.5 * yaw_ratio
                             : like_filter;
  const double moves = std::max(like_filter, goes_on);
  const double stands = log_density(seen, sigma, 0.0, 0.0);
  const double map = tuning.outlier_range * model.car.wheelbase();
  const double anywhere = -0.5 * std::log(squared(squared(map)) * squared(std::numbers::pi));
  // If the wheels are still, a tracker that shows no motion is at fault only half of the time.
  const double share = state.standstill.wheels_still ? 0.5 : 1.0;
  const double other = std::max(stands, anywhere);
  return moves - other - std::log(share * std::exp(stands - other) + std::exp(anywhere - other));
}

/// White innovations are independent of each other: a correlation of ν with m beyond chance shows a
/// lasting error.
/// c is a Gauss-Markov process, ν = c - e + noise, and an update is e ← e + K (c - e).
void note_lasting(const Tuning& tuning, LastingError& lasting, std::span<const double> nu, double K,
                  double S, double dt) noexcept {
  auto& [seen_s, mean, product, expected, e_c, e_e, m_c, m_e, variance] = lasting;
  seen_s = std::min(seen_s + dt, tuning.lasting_memory_s);
  const double share = std::min(dt / std::max(seen_s, tuning.lasting_mean_s), 0.5);
  const double fresh = std::min(dt / tuning.lasting_mean_s, 0.5);
  const double fades = std::exp(-dt / tuning.lasting_s);
  e_c *= fades;
  m_c *= fades;
  double common = 0.0;
  for (std::size_t i = 0; i < nu.size(); ++i) {
    common += nu[i] * mean[i] / static_cast<double>(nu.size());
    mean[i] += fresh * (nu[i] - mean[i]);
  }
  const double counts_by = m_c - m_e;
  product += share * (common * counts_by - product);
  expected += share * (squared(counts_by) - expected);
  m_e = (1.0 - fresh) * ((1.0 - K) * m_e + K * m_c) +
        fresh * ((1.0 - K) * (e_c - e_e) + K * (1.0 - e_c));
  m_c = (1.0 - fresh) * m_c + fresh * (1.0 - e_c);
  e_e = squared(1.0 - K) * e_e + 2.0 * K * (1.0 - K) * e_c + squared(K);
  e_c += K * (1.0 - e_c);
  // Four sigmas of `product` for white innovations
  const double chance = 2.0 * S * std::sqrt(fresh * share * expected);
  variance = 0.0;
  if (product > 0.0 && expected > 0.0) {
    variance = e_e * product / expected / (1.0 + squared(chance / product));
  }
}

/// Starts at a camera pose, without correlations; a second pose has to confirm it.
void begin_at(State& state, const Sample& pose) noexcept {
  state.mean.head<3>() << pose.value[0], pose.value[1], wrap_angle(pose.value[2]);
  for (std::size_t i = 0; i < pose_states.size(); ++i) {
    forget(state, pose_states[i], pose.sigma[i]);
  }
  state.located = state.unconfirmed = true;
}

/// If innovations are biased, the pose follows the camera, so a share of their mean is disputed.
void dispute_drawn(const Tuning& tuning, State& state) noexcept {
  const Eigen::Vector2d way = tuning.fault_share * Eigen::Vector2d(state.lasting_way.mean.data());
  const double turn = tuning.fault_share * state.lasting_turn.mean[0];
  if (way.norm() > state.disputed.head<2>().norm()) {
    state.disputed.head<2>() = way;
  }
  if (std::abs(turn) > std::abs(state.disputed[2])) {
    state.disputed[2] = turn;
  }
}

/// The filter is wrong by ν: widens the pose, within the limits of P, and the velocity and gyro
/// bias that may have caused ν since the last fused pose. The map may have jumped instead, by the
/// part of ν that S does not explain.
void widen(const CarModel& model, State& state, const std::array<double, 3>& nu,
           const Eigen::Matrix3d& S, double since_fused_s, bool first) noexcept {
  const double way = std::min(squared(nu[0]) + squared(nu[1]), squared(largest_camera_sigma));
  const double turn = squared(nu[2]);
  const double dt = std::max(since_fused_s, shortest_drift_s);
  const double speed = std::hypot(state.mean[at::v_x], state.mean[at::v_y]);
  state.covariance.diagonal().head<3>() += Eigen::Vector3d(way, way, turn);
  const double drift = std::min(std::sqrt(way) / dt, std::max(1.0, 0.5 * speed));
  state.covariance.diagonal().segment<2>(at::v_x).array() += squared(drift);
  state.variance(slow::gyro_bias) += std::min(turn / squared(dt), squared(model.tuning.gyro_bias));
  if (first) {
    return;
  }
  // The filter knows little about a sliding car, so less of the correction is disputed.
  const bool slides = state.integrity.slides();
  const double share = slides ? squared(model.tuning.fault_share) : model.tuning.fault_share;
  const auto unexplained = [share](double square, double variance) {
    return share * std::sqrt(1.0 - variance / std::max(square, variance));
  };
  state.disputed.head<2>() += unexplained(way, S(0, 0) + S(1, 1)) * Eigen::Vector2d(nu[0], nu[1]);
  state.disputed[2] += unexplained(turn, S(2, 2)) * nu[2];
  state.doubtful = state.doubtful || !slides;
}

}  // namespace

/// The step error's change n_k - 2 n_k-1 + n_k-2 has six times the variance of one pose. The scale
/// tracks the median of its square, 2.37 for χ² with three degrees of freedom: robust against
/// outliers. At first it adapts fast: stated sigmas may be wrong by orders of magnitude.
void note_camera_pose(State& state, const Sample& pose) noexcept {
  constexpr double median = 2.37;
  constexpr double shortest_step = 0.15;
  constexpr double most = 1e6;
  const auto& [x, y, yaw] = pose.value;
  const PosePair before = std::exchange(
      state.last_camera_pose,
      {.capture_ns = pose.time_ns, .measured = {x, y, yaw}, .estimated = state.pose()});
  if (before.capture_ns == 0) {
    return;
  }
  PosePair& now = state.last_camera_pose;
  now.step_error = step_difference(before, now);
  now.seen = {now.measured.x - before.measured.x, now.measured.y - before.measured.y,
              wrap_angle(now.measured.yaw - before.measured.yaw)};
  now.seen_s = seconds_between(before.capture_ns, now.capture_ns);
  // Over a longer pause, errors of the motion add to those of the poses.
  if (before.seen_s == 0.0 || std::max(before.seen_s, now.seen_s) > longest_pause_s) {
    return;
  }
  const Pose2 change = now.step_error - before.step_error;
  const double ratio =
      ((squared(change.x) + squared(change.y)) / (squared(pose.sigma[0]) + squared(pose.sigma[1])) +
       0.5 * squared(change.yaw / pose.sigma[2])) *
      third;
  double& noise_scale = state.camera_noise_scale;
  const double step = std::max(shortest_step, 1.0 / std::sqrt(++state.camera_steps));
  noise_scale =
      std::clamp(noise_scale * std::exp(ratio > median * noise_scale ? step : -step), 1.0, most);
}

Judgement take_camera(const CarModel& model, const CameraGate& gate, State& state,
                      const PosePair& before, const Sample& stated) noexcept {
  Sample sample = stated;
  Judgement judgement{.source = Source::camera};
  const auto& [z_x, z_y, z_yaw] = stated.value;
  std::int64_t& fused_ns = state.reading(Source::camera).fused_ns;
  const double since_fused_s = seconds_between(fused_ns, sample.time_ns);
  const bool first = fused_ns == 0;
  const auto fused = [&] {
    fused_ns = sample.time_ns;
    state.camera_evidence = 0.0;
    state.turned_since_ns = sample.time_ns;
    state.turned = 0.0;
    state.turned_by.setZero();
    state.confirming_poses = std::min(state.confirming_poses + 1, poses_to_confirm);
    state.doubtful = state.doubtful && state.confirming_poses < poses_to_confirm;
    state.last_camera_pose.estimated = state.pose();
  };
  if (!state.located) {
    if (!gate.locates) {
      return {.source = Source::camera, .verdict = Verdict::source_off};
    }
    begin_at(state, sample);
    fused();
    return judgement;
  }

  const Pose2 estimated = state.pose();
  if (state.camera_noise_scale > least_camera_noise_scale) {
    for (double& sigma : sample.sigma) {
      sigma *= std::sqrt(state.camera_noise_scale);
    }
  }
  judgement.degrees = pose_states.size();
  judgement.innovation = difference({z_x, z_y, z_yaw}, estimated);
  const Eigen::Matrix<double, 6, 6> P = covariance_of_motion(state);
  Eigen::Matrix3d S = P.topLeftCorner<3, 3>();
  S.diagonal() += Eigen::Vector3d(sample.sigma.data()).cwiseAbs2();
  judgement.variance = {S(0, 0), S(1, 1), S(2, 2)};
  if (!state.integrity.slides()) {  // while tyres slide, the filter may be wrong
    state.integrity.add_camera_innovation(judgement.innovation, judgement.variance);
  }
  judgement.squared_ratio = mahalanobis_squared(S, judgement.innovation);
  judgement.test_ratio = judgement.squared_ratio / gate.gate;
  state.camera_test_ratio = judgement.test_ratio;

  const bool beyond = !(judgement.test_ratio <= 1.0);
  if (std::exchange(state.unconfirmed, false) && beyond) {
    // Neither of two contradicting poses is better: the next pose has to confirm the newer one.
    begin_at(state, sample);
    judgement.degrees = 0;
    judgement.verdict = Verdict::forced;
    ++state.resets;
    state.last_jump = state.pose() - estimated;
    state.confirming_poses = 0;
    fused();
    return judgement;
  }
  if (beyond) {
    state.confirming_poses = 0;
    state.last_camera_pose.beyond = true;
    if (before.beyond) {
      state.camera_evidence = std::max(
          std::min(state.camera_evidence, 0.0),
          state.camera_evidence + evidence_of_step(model, state, before, sample.sigma,
                                                   squared(judgement.innovation[2]) / S(2, 2)));
    }
    if (state.camera_evidence < model.tuning.outlier_odds) {
      judgement.verdict = Verdict::gated;
      return judgement;
    }
    // Fused although it failed the test, so it does not enter the filter's statistics.
    judgement.degrees = 0;
    judgement.verdict = Verdict::forced;
    if (state.standstill.standing) {
      set_off(model, state, 0.0);
    }
    widen(model, state, judgement.innovation, S, since_fused_s, first);
  }
  // The measured yaw is taken within half a turn of the filter's.
  for (std::size_t i = 0; i < pose_states.size(); ++i) {
    Prediction z;
    z.value = state.mean[pose_states[i]];
    z.variance = squared(sample.sigma[i]);
    z.depends_on(pose_states[i], 1.0);
    const Innovation nu = full::innovation(
        state, z, i == 2 ? estimated.yaw + judgement.innovation[2] : sample.value[i]);
    correct(state, nu, optimal_gain(nu));
    correct_slow_errors(state, nu, all());
  }
  for (Eigen::Index i = 0; i < slow::size; ++i) {
    const SlowPrior& prior = slow_priors.begin()[i];
    state.slow.mean[i] = std::clamp(state.slow.mean[i], prior.lowest, prior.highest);
  }
  if (beyond) {
    ++state.resets;
    state.last_jump = state.pose() - estimated;
  } else if (!first) {
    adapt_way_noise_scale(model.tuning, state, judgement.squared_ratio, since_fused_s);
    if (since_fused_s > model.tuning.lasting_s) {
      state.lasting_way = {};
      state.lasting_turn = {};
    }
    const double dt = std::max(since_fused_s, 1e-3);
    const std::span nu(judgement.innovation);
    const double S_way = 0.5 * (S(0, 0) + S(1, 1));
    note_lasting(model.tuning, state.lasting_way, nu.first(2), 0.5 * (P(0, 0) + P(1, 1)) / S_way,
                 S_way, dt);
    note_lasting(model.tuning, state.lasting_turn, nu.last(1), P(2, 2) / S(2, 2), S(2, 2), dt);
    if (state.integrity.agreed().camera_inconsistent) {
      dispute_drawn(model.tuning, state);
    }
  }
  fused();
  return judgement;
}

}  // namespace odomd::estimator::full
