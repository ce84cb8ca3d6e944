// docs/model.md, "Standstill".
#include "estimator/ekf/standstill.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimator/common/pose.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/judge.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {
namespace {

// A wheel turns if it is faster than twice its noise, within these limits.
constexpr double slowest_turning = 0.01;  // [m/s]
constexpr double surely_turning = 0.03;   // [m/s]

// Spread of a still gyro's readings, and distance from a known bias. The outermost readings are
// slowly forgotten, as a bias drifts with the temperature.
constexpr double quiet_swing = 0.02;   // [rad/s]
constexpr double swing_sigmas = 10.0;  // of its noise
constexpr double bias_sigmas = 6.0;
constexpr double memory_s = 5.0;
// A bias known this well [rad/s] is trusted for this long against readings that stay elsewhere.
constexpr double known_bias = 0.01;
constexpr double bias_trusted_s = 5.0;
constexpr double surprising_ratio = 9.0;
using integrity::largest_gyro_bias;

// Standard deviations of the velocity at standstill, and after setting off.
constexpr double held_sigma = 1e-4;
constexpr double departing_speed = 0.05;     // [m/s]
constexpr double departing_side = 0.02;      // [m/s]
constexpr double departing_yaw_rate = 0.05;  // [rad/s]

void begin_still_period(Standstill& standstill, std::int64_t time_ns) noexcept {
  standstill = {.wheels_still = true, .since_ns = time_ns};
  standstill.lowest_gyro = std::numeric_limits<double>::max();
  standstill.highest_gyro = std::numeric_limits<double>::lowest();
}

/// Fuses v = 0, which also corrects all correlated states.
void enter_standstill(State& state, std::int64_t time_ns) noexcept {
  Standstill& standstill = state.standstill;
  standstill.standing = true;
  // A change of the bias must not move the pose that was driven with the old one.
  detach_from_pose(state, slow::gyro_bias);
  if (standstill.lowest_gyro <= standstill.highest_gyro) {
    // The reading is the bias, however unlikely.
    const double surprise =
        0.5 * (standstill.lowest_gyro + standstill.highest_gyro) - state.slow.mean[slow::gyro_bias];
    double& variance = state.slow.covariance(slow::gyro_bias, slow::gyro_bias);
    if (surprise * surprise > surprising_ratio * variance) {
      variance += surprise * surprise;
      // Until now it was integrated as a turn.
      const double turned = surprise * seconds_between(standstill.since_ns, time_ns);
      state.covariance(at::yaw, at::yaw) += turned * turned;
    }
  }
  for (const at::Index index : {at::v_x, at::v_y, at::yaw_rate, at::accel_x}) {
    Prediction zero;
    zero.value = state.mean[index];
    zero.variance = held_sigma * held_sigma;
    zero.depends_on(index, 1.0);
    const Innovation nu = innovation(state, zero, 0.0);
    // Standing now is no evidence of the way here.
    Vector gain = optimal_gain(nu);
    gain.head<3>().setZero();
    correct(state, nu, gain);
  }
  // The velocity stays zero and uncorrelated while the car stands.
  state.mean.segment<6>(at::v_x).setZero();  // v_x ... side_force
  for (const at::Index index :
       {at::v_x, at::v_y, at::yaw_rate, at::accel_x, at::front_angle, at::side_force}) {
    forget(state, index, std::sqrt(state.covariance(index, index)));
  }
}

}  // namespace

/// The wheels may have turned below the slowest speed that they resolve: for the distance ½ v² / a.
void set_off(const CarModel& model, State& state, double speed) noexcept {
  state.standstill = {};
  const Eigen::Vector2d way = state.along_heading(0.5 * speed * speed / brisk_accel);
  state.covariance.topLeftCorner<2, 2>() += way * way.transpose();
  forget(state, at::v_x, std::max(departing_speed, std::abs(speed)));
  forget(state, at::v_y, departing_side);
  forget(state, at::yaw_rate, departing_yaw_rate);
  forget(state, at::accel_x, model.tuning.drive_accel * gravity);
  forget(state, at::front_angle, model.tuning.front_angle);
  forget(state, at::side_force, model.tuning.side_force_floor * gravity);
}

void begin_motion(State& state, const Sample& sample) noexcept {
  const double speed = sample.value[0];
  const double yaw_rate = state.mean[at::yaw_rate];
  const std::int64_t consistent_ns = consistent_since_ns(state, sample);
  const std::int64_t camera_ns = state.fused_ns[index_of(Source::camera)];
  const Pose2 pose = moved(state.pose(), {speed, 0.0, yaw_rate},
                           seconds_between(std::max(consistent_ns, camera_ns), sample.time_ns));
  const double uncertain = 0.5 * std::hypot(pose.x - state.mean[at::x], pose.y - state.mean[at::y]);
  state.covariance.diagonal().head<2>().array() += uncertain * uncertain;
  state.moving = true;
  state.turned_since_ns = 0;
  state.mean.segment<4>(at::x) << pose.x, pose.y, pose.yaw, speed;
  if (camera_ns != 0 && camera_ns < consistent_ns) {
    const double unknown_s = seconds_between(camera_ns, consistent_ns);
    const double way = speed * unknown_s;
    const double turn = yaw_rate * unknown_s;
    state.covariance.diagonal().head<3>() += Eigen::Vector3d(way * way, way * way, turn * turn);
  }
}

bool sets_off(State& state, const Sample& sample, const WheelCount& wheels) noexcept {
  const Reading& before = state.readings[index_of(sample.source)];
  if (wheels.turning > wheels.still) {
    return wheels.turning > 1 ||
           (consistent_samples(state, sample) > 0 &&
            (is_turning(before.value, sample.sigma[0]) ||
             seconds_between(before.time_ns, sample.time_ns) > next_sample_s));
  }
  return rejected_s(state, sample) >= dead_after_s && wheels.turning == wheels.still &&
         (wheels.free_turning || !wheels.free_still);
}

bool is_turning(double speed, double sigma) noexcept {
  return std::abs(speed) > std::clamp(2.0 * sigma, slowest_turning, surely_turning);
}

void update_standstill_by_wheels(State& state, std::int64_t time_ns) noexcept {
  Standstill& standstill = state.standstill;
  if (!standstill.wheels_still) {
    begin_still_period(standstill, time_ns);
  } else if (!standstill.standing &&
             seconds_between(standstill.since_ns, time_ns) >=
                 (standstill.gyro_off_bias ? bias_trusted_s : standing_after_s)) {
    enter_standstill(state, time_ns);
  }
}

void update_standstill_by_gyro(const CarModel& model, State& state, std::int64_t time_ns,
                               double yaw_rate, double sigma) noexcept {
  Standstill& standstill = state.standstill;
  if (!standstill.wheels_still) {
    return;
  }
  const bool first = standstill.highest_gyro < standstill.lowest_gyro;
  const bool known =
      state.slow.covariance(slow::gyro_bias, slow::gyro_bias) < known_bias * known_bias;
  const auto far_from_bias = [&](double reading) {
    return known &&
           std::abs(reading - state.slow.mean[slow::gyro_bias]) > quiet_swing + bias_sigmas * sigma;
  };
  const auto leaves = [&](double reading) {
    return std::max(reading, standstill.highest_gyro) - std::min(reading, standstill.lowest_gyro) >
               quiet_swing + swing_sigmas * sigma ||
           std::abs(reading) > largest_gyro_bias || (standstill.standing && far_from_bias(reading));
  };
  const Reading& before = state.readings[index_of(Source::yaw_rate)];
  if (standstill.standing && !first && leaves(yaw_rate) && before.consistent > 0 &&
      !leaves(before.value) && seconds_between(before.time_ns, time_ns) <= next_sample_s) {
    return;  // one corrupt frame does not end a standstill
  }
  const bool left = !first && leaves(yaw_rate);
  const double forgotten =
      std::clamp(seconds_between(standstill.gyro_ns, time_ns) / memory_s, 0.0, 1.0);
  const auto after = [&](double extreme) {
    return first ? yaw_rate : extreme + forgotten * (yaw_rate - extreme);
  };
  standstill.gyro_ns = time_ns;
  standstill.lowest_gyro = std::min(yaw_rate, after(standstill.lowest_gyro));
  standstill.highest_gyro = std::max(yaw_rate, after(standstill.highest_gyro));
  standstill.gyro_off_bias = far_from_bias(yaw_rate);
  if (!left && std::abs(yaw_rate) <= largest_gyro_bias) {
    return;
  }
  if (standstill.standing) {
    set_off(model, state, brisk_accel * seconds_between(last_wheel_ns(state), time_ns));
  }
  begin_still_period(standstill, time_ns);
}

}  // namespace odomd::estimator::full
