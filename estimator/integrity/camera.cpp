#include "estimator/integrity/camera.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/noise.hpp"
#include "estimator/ekf/update.hpp"
#include "estimator/integrity/standstill.hpp"

namespace odomd::estimator::full {
namespace {

constexpr std::array<at::Index, 3> pose_states{at::x, at::y, at::yaw};

// Rejected poses agree where the way from one to the next is the filter's, give or take this.
constexpr double agreeing_share = 0.25;     // of the way
constexpr double agreeing_distance = 0.05;  // [m], and four sigmas of the poses
constexpr double agreeing_yaw = 0.1;        // [rad], likewise
// A car changes its velocity no faster from one pose to the next ...
constexpr double possible_accel = 15.0;      // [m/s²]
constexpr double possible_yaw_accel = 60.0;  // [rad/s²]
// ... and has gone somewhere by then.
constexpr double driven_distance = 0.1;  // [m]
constexpr double driven_yaw = 0.2;       // [rad]
constexpr double longest_pause_s = 0.5;  // between two poses of one run
constexpr double long_run_s = 2.0;       // of a car that creeps

// How well the velocity is known after the pose turned out to be wrong.
constexpr double doubted_speed = 0.1;         // [m/s]
constexpr double doubted_bias = 0.03;         // [rad/s], of the gyro
constexpr double largest_doubted_bias = 0.1;  // [rad/s]
constexpr double shortest_run_s = 0.1;
constexpr double significant = 3.0;  // sigmas
// By how much the motion now may differ from that between two poses.
constexpr double changed_speed = 0.2;     // [m/s]
constexpr double changed_yaw_rate = 0.5;  // [rad/s]

/// What no tyre and no sensor is off by, and where the model would lose its sense.
void keep_scales_possible(State& state) noexcept {
  LastingVector& scales = state.lasting.mean;
  const auto keep = [&scales](lasting::Index index, double lowest, double highest) {
    scales[index] = std::clamp(scales[index], lowest, highest);
  };
  keep(lasting::stiffness_scale, -0.7, 2.0);
  keep(lasting::gyro_scale, -0.5, 0.5);
  keep(lasting::wheel_scale, -0.5, 0.5);
}

/// The nearer way round: each heading was seen next to the filter's, which the other's was not.
double turn_between(const Pose2& from, const Pose2& to) noexcept {
  return wrap_angle(to.yaw - from.yaw);
}

/// By how much the way that was seen from one to the other differs from the filter's, told along
/// the car: a heading that is wrong turns the filter's way, and makes it no other.
Pose2 apart(const Sighting& before, const Sighting& now) noexcept {
  const double heading = before.seen.yaw - before.believed.yaw;
  const double c = std::cos(heading);
  const double s = std::sin(heading);
  const double x = now.seen.x - before.seen.x;
  const double y = now.seen.y - before.seen.y;
  return {c * x + s * y - (now.believed.x - before.believed.x),
          c * y - s * x - (now.believed.y - before.believed.y),
          wrap_angle(now.seen.yaw - before.seen.yaw - (now.believed.yaw - before.believed.yaw))};
}

double way_between(const Pose2& from, const Pose2& to) noexcept {
  return std::hypot(to.x - from.x, to.y - from.y);
}

/// How far apart two poses of one place may lie [m], and two headings that are one [rad].
double noise_between(const std::array<double, 3>& sigma) noexcept {
  return 4.0 * std::numbers::sqrt2 * std::hypot(sigma[0], sigma[1]);
}
double yaw_noise_between(const std::array<double, 3>& sigma) noexcept {
  return 4.0 * std::numbers::sqrt2 * sigma[2];
}

bool agree(const Sighting& before, const Sighting& now,
           const std::array<double, 3>& sigma) noexcept {
  const auto [dx, dy, turn] = apart(before, now);
  const double way = way_between(before.believed, now.believed);
  return std::hypot(dx, dy) <= agreeing_share * way + agreeing_distance + noise_between(sigma) &&
         std::abs(turn) <= agreeing_yaw + yaw_noise_between(sigma);
}

/// Whether the filter has gone so far since then that a picture that stands still would not have
/// agreed with it all the way; or has crept for so long that little is lost by believing one.
bool tells_frozen(const Sighting& before, const Sighting& now,
                  const std::array<double, 3>& sigma) noexcept {
  return way_between(before.believed, now.believed) >
             2.0 * (agreeing_distance + noise_between(sigma)) ||
         seconds_between(before.capture_ns, now.capture_ns) > long_run_s;
}

/// Whether a car could have gone on to `now` as it has come, be the filter's velocity what it may.
bool possible(const CameraContender& run, const Sighting& now,
              const std::array<double, 3>& sigma) noexcept {
  if (run.steady < 2) {
    return true;
  }
  const double before_s = seconds_between(run.before_last.capture_ns, run.last.capture_ns);
  const double now_s = seconds_between(run.last.capture_ns, now.capture_ns);
  const double share = now_s / before_s;
  const Pose2& a = run.before_last.seen;
  const Pose2& b = run.last.seen;
  const Pose2& c = now.seen;
  const double dx = (c.x - b.x) - share * (b.x - a.x);
  const double dy = (c.y - b.y) - share * (b.y - a.y);
  const double turn = turn_between(b, c) - share * turn_between(a, b);
  const double changing_s2 = 0.5 * now_s * (before_s + now_s);
  const double noise = 4.0 * std::sqrt(2.0 * (1.0 + share + share * share));
  return std::hypot(dx, dy) <=
             possible_accel * changing_s2 + noise * std::hypot(sigma[0], sigma[1]) &&
         std::abs(turn) <= possible_yaw_accel * changing_s2 + noise * sigma[2];
}

/// A long run of poses that a car could have come through, and has: a picture that stands still is
/// no car that slips.
bool seen_driving(const CameraContender& run, const std::array<double, 3>& sigma) noexcept {
  const Pose2& from = run.first_steady.seen;
  const Pose2& to = run.last.seen;
  return run.steady >= believed_rejections &&
         (way_between(from, to) > std::max(driven_distance, noise_between(sigma)) ||
          std::abs(turn_between(from, to)) > std::max(driven_yaw, yaw_noise_between(sigma)));
}

/// A pose that was wrong came of a motion that was: by as much as the run's own motion is not the
/// filter's. Where the ways differ it is the wheels that erred, or may have.
void doubt_motion(State& state, const CameraContender& run,
                  const std::array<double, 3>& sigma) noexcept {
  const auto squared = [](double value) { return value * value; };
  const auto [dx, dy, turn] = apart(run.first_steady, run.last);
  const double run_s =
      std::max(seconds_between(run.first_steady.capture_ns, run.last.capture_ns), shortest_run_s);
  const double noise = 2.0 * squared(significant);
  const double way = std::max(squared(dx) + squared(dy) - noise * squared(sigma[0]), 0.0);
  const double turned = std::max(squared(turn) - noise * squared(sigma[2]), 0.0);
  const double yaw_rate = turned / squared(run_s);
  const double speed = squared(doubted_speed) + way / squared(run_s);
  state.covariance(at::v_x, at::v_x) += speed;
  state.covariance(at::v_y, at::v_y) += speed;
  state.covariance(at::yaw_rate, at::yaw_rate) += yaw_rate;
  state.lasting.covariance(lasting::gyro_bias, lasting::gyro_bias) +=
      std::min(squared(doubted_bias) + yaw_rate, squared(largest_doubted_bias));
  if (way > 0.0) {
    state.wheels_doubted_until_ns =
        ns_after(run.last.capture_ns, std::llround(wheels_doubted_s * ns_per_second));
  }
}

/// The motion is what two poses show, and no force that the filter has made up explains it.
void take_motion(const CarModel& model, State& state, const Sighting& before, const Sighting& now,
                 const std::array<double, 3>& sigma) noexcept {
  const auto take = [&state](at::Index index, double seen, double deviation) {
    Prediction z;
    z.value = state.mean[index];
    z.variance = deviation * deviation;
    z.depends_on(index, 1.0);
    const Innovation nu = innovation(state, z, seen);
    correct(state, nu, optimal_gain(nu));
  };
  state.mean[at::accel_x] = state.mean[at::front_angle] = state.mean[at::side_force] = 0.0;
  forget(state, at::accel_x, model.tuning.drive_accel * gravity);
  forget(state, at::front_angle, model.tuning.front_angle);
  forget(state, at::side_force, model.tuning.side_force_floor * gravity);

  const double step_s = seconds_between(before.capture_ns, now.capture_ns);
  const double turn = turn_between(before.seen, now.seen);
  const double yaw = before.seen.yaw + 0.5 * turn;
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  const double v_x = ((now.seen.x - before.seen.x) * c + (now.seen.y - before.seen.y) * s) / step_s;
  const double v_y = ((now.seen.y - before.seen.y) * c - (now.seen.x - before.seen.x) * s) / step_s;
  const double yaw_rate = turn / step_s;
  const double noise = std::sqrt(2.0) / step_s;
  take(at::v_x, v_x, std::hypot(changed_speed, noise * sigma[0]));
  take(at::v_y, v_y, std::hypot(changed_speed, noise * sigma[1]));
  take(at::yaw_rate, yaw_rate, std::hypot(changed_yaw_rate, noise * sigma[2]));
}

/// The pose becomes `seen`, its covariance that of the camera, and nothing else is related to it.
void move_to(State& state, const Pose2& seen, const std::array<double, 3>& sigma) noexcept {
  state.mean.head<3>() << seen.x, seen.y, seen.yaw;
  for (std::size_t i = 0; i < pose_states.size(); ++i) {
    forget(state, pose_states[i], sigma[i]);
  }
}

}  // namespace

Judgement take_camera(const CarModel& model, const CameraGate& gate, State& state,
                      const Sample& sample) noexcept {
  Judgement judgement{.source = Source::camera, .verdict = Verdict::fused, .degrees = 0};
  const auto& [z_x, z_y, z_yaw] = sample.value;
  const auto fused = [&] {
    state.fused_ns[static_cast<std::size_t>(Source::camera)] = sample.time_ns;
    state.contender = {};
    state.turned_since_ns = 0;
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
      teach(state, nu, all());
    }
    keep_scales_possible(state);
    const std::int64_t before_ns = state.fused_ns[index_of(Source::camera)];
    if (before_ns != 0) {
      follow_way_unrest(model.tuning, state, judgement.squared_ratio,
                        seconds_between(before_ns, sample.time_ns));
    }
    fused();
    return judgement;
  }

  const CameraContender before = state.contender;
  const Sighting now{sample.time_ns, seen, believed};
  const double dt = seconds_between(before.last.capture_ns, sample.time_ns);
  const bool goes_on = before.steady > 0 && dt <= longest_pause_s;
  if (goes_on && !state.rest.standing && seen.x == before.last.seen.x &&
      seen.y == before.last.seen.y) {
    // To the bit, of a car that drives: a tracker that repeats what it saw last.
    judgement.verdict = Verdict::gated;
    return judgement;
  }
  const bool steady = goes_on && possible(before, now, sample.sigma);
  const bool agrees = goes_on && agree(before.last, now, sample.sigma) &&
                      agree(before.first_agreeing, now, sample.sigma);
  state.contender = {.agreeing = agrees ? before.agreeing + 1 : 1,
                     .steady = steady ? before.steady + 1 : 1,
                     .first_agreeing = agrees ? before.first_agreeing : now,
                     .first_steady = steady ? before.first_steady : now,
                     .before_last = before.last,
                     .last = now};
  const bool goes_as_believed =
      state.contender.agreeing >= believed_rejections &&
      (state.rest.standing || tells_frozen(state.contender.first_agreeing, now, sample.sigma));
  if (!goes_as_believed && !seen_driving(state.contender, sample.sigma)) {
    judgement.verdict = Verdict::gated;
    return judgement;
  }
  // Believed against the test: it does not count among those that the filter expects.
  judgement.degrees = 0;
  if (state.rest.standing) {
    set_off(model, state, 0.0);
  }
  move_to(state, seen, sample.sigma);
  doubt_motion(state, state.contender, sample.sigma);
  if (!goes_as_believed) {
    take_motion(model, state, before.last, now, sample.sigma);
  }
  ++state.resets;
  state.last_jump = {seen.x - believed.x, seen.y - believed.y, seen.yaw - believed.yaw};
  fused();
  return judgement;
}

}  // namespace odomd::estimator::full
