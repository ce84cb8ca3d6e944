// docs/model.md, "Standstill".
#include "estimator/ekf/standstill.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "estimator/common/pose.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/judge.hpp"
#include "estimator/ekf/measurement_models.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {
namespace {

// Share of a new pose in the mean of a standing car's poses.
constexpr double camera_share = 0.125;
// Still gyro [s]: period over which the range of its readings is taken; time constant of its mean.
constexpr double swing_s = 0.15;
constexpr double drifts_s = 5.0;

// Standard deviations of the velocity at standstill, and after setting off.
constexpr double held_sigma = 1e-4;
constexpr double departing_speed = 0.05;  // [m/s, rad/s]
constexpr double departing_side = 0.02;   // [m/s]

/// log p(off | the car stands) - log p(off | it moves) for one source: `off` is the deviation of
/// its reading from a standing car's, `sigma` the deviation expected at rest. A moving car adds
/// `range` or, half of the time, nothing. Student's t: no single source is certain.
double evidence(double off, double sigma, double range) noexcept {
  const auto log_density = [off](double variance) {
    return -0.5 * (student_degrees + 1.0) * std::log1p(off * off / (student_degrees * variance)) -
           0.5 * std::log(variance);
  };
  const double moving = log_density(sigma * sigma + range * range) - log_density(sigma * sigma);
  return std::numbers::ln2 - std::log1p(std::exp(moving));
}

/// The log odds that the car stands at `time_ns`, from all sources since the wheels read 0.
double odds_of_standing(const CarModel& model, const State& state, std::int64_t time_ns) noexcept {
  const Standstill& standstill = state.standstill;
  const double dead_band = smallest_dead_band(state);
  const Tuning& tuning = model.tuning;
  const double still_s = seconds_between(standstill.since_ns, last_wheel_ns(state));
  // 1. A moving car soon leaves the dead band of its wheels. Silent wheels may have left it.
  const double leaves_s = tuning.still_s + tuning.still_per_speed * dead_band;
  const double silence_s = wheel_silence_s(state, time_ns);
  const double most = standstill.standing ? 2.0 * tuning.standing_odds : tuning.most_odds;
  double odds = std::max(std::min(still_s / leaves_s, most) - silence_s / leaves_s,
                         -silence_s / tuning.departs_s) -
                standstill.blind;
  // 2. The gyro of a standing car reads its bias and is constant.
  const double speed = dead_band + brisk_accel * tuning.still_s;
  const double turn = speed * tuning.sharpest_turn / model.car.wheelbase();
  const integrity::SourceHistory& gyro = state.integrity.history(Source::yaw_rate);
  if (gyro.alive(state.time_ns)) {
    const double noise = gyro.noise(integrity::Over::short_time);
    const double bias = state.variance(slow::gyro_bias);
    // A step of the bias may explain a deviation, which limits the evidence.
    odds +=
        std::max(evidence(gyro.mean() - (standstill.standing ? standstill.still_gyro
                                                             : state.slow.mean[slow::gyro_bias]),
                          std::sqrt(noise * noise + bias), turn),
                 -tuning.bias_step_odds);
    const auto& [older, newer] = standstill.gyro_ranges;
    const double swing =
        std::max(older.highest, newer.highest) - std::min(older.lowest, newer.lowest);
    odds += 2.0 * evidence(swing, most_sigmas * gyro.sigma, turn);  // counts twice: two stretches
  }
  // 3. A car whose wheels read 0 because it changes direction accelerates.
  const integrity::SourceHistory& accel = state.integrity.history(Source::accel_x);
  if (accel.alive(state.time_ns)) {
    const double noise = accel.noise(integrity::Over::short_time);
    const double bias = state.variance(at::accel_bias_x);
    odds += evidence(accel.mean() - state.mean[at::accel_bias_x], std::sqrt(noise * noise + bias),
                     tuning.pedal * gravity);
  }
  // 4. The camera sees a standing car in one place. Compares the mean of the camera's poses with
  // the held pose or, before the standstill, the newest pose with the first.
  if (standstill.camera_ns != 0) {
    const double seen_s = seconds_between(standstill.camera_ns, state.last_camera_pose.capture_ns);
    const double known = state.variance(at::x) + state.variance(at::y);
    const double variance = squared(standstill.camera_sigma) *
                                (standstill.standing ? camera_share / (2.0 - camera_share) : 2.0) +
                            (standstill.standing ? known : 0.0);
    const double range =
        variance + squared(speed * (standstill.standing ? camera_share : std::max(seen_s, 0.0)));
    const double off = squared(standstill.off.x) + squared(standstill.off.y);
    odds += std::max(0.5 * off * (1.0 / range - 1.0 / variance) + std::log(range / variance),
                     -2.0 * tuning.most_odds);
  }
  return odds;
}

/// Fuses v = 0, which also corrects all correlated states.
void enter_standstill(State& state, std::int64_t time_ns) noexcept {
  Standstill& standstill = state.standstill;
  standstill.standing = true;
  standstill.off = {};
  standstill.still_gyro = state.integrity.history(Source::yaw_rate).mean();
  // A change of the bias must not move the pose that was integrated with the old bias.
  detach_from_pose(state, slow::gyro_bias);
  const integrity::SourceHistory& gyro = state.integrity.history(Source::yaw_rate);
  if (gyro.alive(time_ns)) {
    // The part of the reading that the bias does not explain was integrated as a turn.
    const double off = gyro.mean() - state.slow.mean[slow::gyro_bias];
    state.variance(at::yaw) += std::max(off * off - state.variance(slow::gyro_bias), 0.0) *
                               squared(seconds_between(standstill.since_ns, time_ns));
  }
  for (const at::Index index : {at::v_x, at::v_y, at::yaw_rate, at::accel_x}) {
    Prediction zero;
    zero.value = state.mean[index];
    zero.variance = held_sigma * held_sigma;
    zero.depends_on(index, 1.0);
    const Innovation nu = innovation(state, zero, 0.0);
    // Standing now says nothing about the path so far.
    Vector gain = optimal_gain(nu);
    gain.head<3>().setZero();
    correct(state, nu, gain);
  }
  // The velocity stays zero and uncorrelated while the car stands.
  state.mean.segment<6>(at::v_x).setZero();  // v_x ... side_force
  for (const at::Index index :
       {at::v_x, at::v_y, at::yaw_rate, at::accel_x, at::front_angle, at::side_force}) {
    forget(state, index, std::sqrt(state.variance(index)));
  }
}

}  // namespace

/// The wheels may have turned below the slowest speed they resolve, over the distance ½ v² / a.
void set_off(const CarModel& model, State& state, double speed) noexcept {
  state.standstill = {.blind = state.standstill.blind, .dead_band = state.standstill.dead_band};
  const Eigen::Vector2d way = state.along_heading(0.5 * speed * speed / brisk_accel);
  state.covariance.topLeftCorner<2, 2>() += way * way.transpose();
  forget(state, at::v_x, std::max(departing_speed, std::abs(speed)));
  forget(state, at::v_y, departing_side);
  forget(state, at::yaw_rate, departing_speed);
  forget(state, at::accel_x, model.tuning.drive_accel * gravity);
  forget(state, at::front_angle, model.tuning.front_angle);
  forget(state, at::side_force, model.tuning.side_force_floor * gravity);
}

void begin_motion(State& state, const Sample& sample) noexcept {
  const double speed = sample.value[0];
  const double yaw_rate = state.mean[at::yaw_rate];
  const std::int64_t consistent_ns = consistent_since_ns(state, sample);
  const std::int64_t camera_ns = state.reading(Source::camera).fused_ns;
  state.start = state.pose();
  const Pose2 pose = moved(state.start, {speed, 0.0, yaw_rate},
                           seconds_between(std::max(consistent_ns, camera_ns), sample.time_ns));
  const double uncertain = 0.5 * std::hypot(pose.x - state.mean[at::x], pose.y - state.mean[at::y]);
  state.covariance.diagonal().head<2>().array() += uncertain * uncertain;
  state.moving = true;
  state.turned_since_ns = 0;
  state.mean.segment<4>(at::x) << pose.x, pose.y, pose.yaw, speed;
  state.started_ns = consistent_ns;
  if (camera_ns != 0 && camera_ns < consistent_ns) {
    const double unknown_s = seconds_between(camera_ns, consistent_ns);
    const double way = speed * unknown_s;
    const double turn = yaw_rate * unknown_s;
    state.covariance.diagonal().head<3>() += Eigen::Vector3d(way * way, way * way, turn * turn);
  }
}

void correct_start(State& state, const Sample& sample) noexcept {
  const FirstSpeeds first = first_speeds(state);
  const double off = first.median - state.mean[at::v_x];
  const double surprising = std::max(0.5, 0.5 * std::abs(first.median));
  const bool done = state.started_ns == 0 || std::abs(off) <= surprising;
  const std::int64_t started_ns = std::exchange(
      state.started_ns, first.samples >= integrity::least_samples ? 0 : state.started_ns);
  if (done) {
    return;
  }
  if (state.reading(Source::camera).fused_ns < started_ns) {
    const Pose2 pose = moved(state.start, {first.median, 0.0, state.mean[at::yaw_rate]},
                             seconds_between(started_ns, sample.time_ns));
    state.mean.head<2>() << pose.x, pose.y;
  }
  state.mean[at::v_x] = first.median;
  forget(state, at::v_x, std::abs(off));
}

bool sets_off(State& state, const Sample& sample, const WheelCount& wheels) noexcept {
  const Reading& before = state.reading(sample.source);
  if (wheels.turning > wheels.still) {
    return wheels.turning > 1 ||
           (consistent_samples(state, sample) > 0 &&
            (is_turning(before.value, sample.sigma[0]) ||
             seconds_between(before.time_ns, sample.time_ns) > next_sample_s));
  }
  return rejected_s(state, sample) >= dead_after_s && wheels.turning == wheels.still &&
         (wheels.free_turning || !wheels.free_still);
}

void note_wheels(State& state, const Sample& sample, bool still) noexcept {
  Standstill& standstill = state.standstill;
  if (!still) {
    standstill.wheels_still = false;
  } else if (!standstill.wheels_still) {
    standstill.wheels_still = true;
    standstill.since_ns = sample.time_ns;
    const double reading = state.integrity.history(Source::yaw_rate).mean();
    standstill.gyro_ranges.fill({reading, reading});
    standstill.range_since_ns = sample.time_ns;
    standstill.camera_ns = 0;
  }
}

void update_standstill(const CarModel& model, State& state, const Sample& sample) noexcept {
  Standstill& standstill = state.standstill;
  if (!standstill.wheels_still || !state.moving) {
    return;
  }
  if (sample.source == Source::camera) {
    const Pose2& seen = state.last_camera_pose.measured;
    if (standstill.camera_ns == 0) {
      standstill.camera_ns = sample.time_ns;
      standstill.first_seen = seen;
      standstill.camera_sigma =
          std::max(sample.sigma[0], sample.sigma[1]) * std::sqrt(state.camera_noise_scale);
    }
    const Pose2 from = standstill.standing ? state.pose() : standstill.first_seen;
    const double share = standstill.standing ? camera_share : 1.0;
    standstill.off.x += share * (seen.x - from.x - standstill.off.x);
    standstill.off.y += share * (seen.y - from.y - standstill.off.y);
  } else if (sample.source == Source::yaw_rate) {
    // The median of three: one corrupt frame does not show motion.
    const Reading& before = state.reading(sample.source);
    const auto [least, most] = std::minmax(sample.value[0], before.previous);
    const double reading = std::clamp(before.value, least, most);
    auto& [older, newer] = standstill.gyro_ranges;
    if (seconds_between(standstill.range_since_ns, sample.time_ns) >= swing_s) {
      older = std::exchange(newer, {reading, reading});
      standstill.range_since_ns = sample.time_ns;
    }
    newer = {std::min(reading, newer.lowest), std::max(reading, newer.highest)};
    // A bias drifts with the temperature.
    standstill.still_gyro +=
        std::min(before.interval_s / drifts_s, 1.0) *
        (state.integrity.history(Source::yaw_rate).mean() - standstill.still_gyro);
  }
  if (standstill.standing) {
    const double less = model.tuning.standing_odds;
    if (doubt_standstill(model, state, sample.time_ns) && sample.source == Source::camera) {
      // Wheels that read 0 while the camera sees the car move count less from now on.
      standstill.blind = std::min(standstill.blind + less, 2.0 * less);
    }
  } else if (odds_of_standing(model, state, sample.time_ns) > model.tuning.standing_odds) {
    enter_standstill(state, sample.time_ns);
  }
}

bool doubt_standstill(const CarModel& model, State& state, std::int64_t time_ns) noexcept {
  const bool sets_off = odds_of_standing(model, state, time_ns) < -model.tuning.standing_odds;
  if (sets_off) {  // the wheels have shown nothing since their last sample
    set_off(model, state, brisk_accel * seconds_between(last_wheel_ns(state), time_ns));
  }
  return sets_off;
}

Judgement take_still_gyro(const CarModel& model, State& state, const Sample& sample) noexcept {
  const Judgement unused{.source = sample.source};
  constexpr double stretch_s = 0.25;
  constexpr double bias_step_s = 20.0;
  auto& [older, newer] = state.standstill.gyro;
  newer.since_ns = newer.samples == 0 ? sample.time_ns : newer.since_ns;
  newer.sum += sample.value[0];
  ++newer.samples;
  state.reading(sample.source).fused_ns = sample.time_ns;
  if (seconds_between(newer.since_ns, sample.time_ns) < stretch_s) {
    return unused;
  }
  const StillGyro stretch = std::exchange(older, std::exchange(newer, {}));
  if (stretch.samples == 0) {
    return unused;
  }
  Sample mean = sample;
  mean.value[0] = stretch.sum / stretch.samples;
  // A stretch counts less if its mean differs from that of the next stretch.
  const double noise = squared(mean.sigma[0]) / stretch.samples;
  const double of_both = noise + squared(mean.sigma[0]) / older.samples;
  const double unlike = squared(mean.value[0] - older.sum / older.samples);
  mean.sigma[0] = std::sqrt(noise + std::max(unlike - squared(most_sigmas) * of_both, 0.0));
  const Prediction z = predict_yaw_rate(state, mean.sigma[0]);
  // A step of the bias counts only if it lasts: the excess widens the bias for the next stretch.
  const Innovation nu = innovation(state, z, mean.value[0]);
  const double excess = std::max(nu.value * nu.value - nu.variance, 0.0);
  const Judgement judgement =
      judge(model, state, mean, z, {.heading = false, .slow = only(slow::gyro_bias)});
  state.variance(slow::gyro_bias) += excess * stretch_s / bias_step_s;
  return judgement;
}

void learn_dead_band(State& state, const Sample& sample) noexcept {
  const Reading& before = state.reading(sample.source);
  // A wheel that trembles while the others stand does not show motion.
  const bool alone = state.standstill.wheels_still && is_single_wheel(sample.source);
  if (!alone && before.consistent > 0 && sample.value[0] != 0.0 && before.value != 0.0) {
    const double shown =
        std::max({std::abs(sample.value[0]), std::abs(before.value), slowest_turning});
    const double own = state.standstill.dead_band[index_of(sample.source)];
    for (const Source wheel : wheel_sources) {
      double& dead_band = state.standstill.dead_band[index_of(wheel)];
      if (wheel == sample.source ||
          (dead_band == own && is_single_wheel(wheel) && is_single_wheel(sample.source))) {
        dead_band = std::min(dead_band, shown);
      }
    }
  }
}

}  // namespace odomd::estimator::full
