// docs/model.md, "Integrity".
#include "estimator/ekf/apply_integrity.hpp"

#include <cmath>
#include <utility>

#include "estimator/common/squares.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/standstill.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {
namespace {

namespace of = integrity::of;

// The filter deviates from the consensus if it is off by this many sigmas for this long.
constexpr double deviation_sigmas = 4.0;
constexpr double deviation_s = 0.1;
// A source's disagreement begins at this many sigmas.
constexpr double onset_sigmas = 1.5;
// Sources that contradict each other for this long make the pose doubtful.
constexpr double contradicted_s = 0.25;

/// Sums what the filter has driven or turned beyond the motion by the others since a disagreement
/// began. Whether the sources that measure this motion have just failed.
bool follow(const State& state, Deviation& deviation, at::Index index,
            const integrity::Solution& others, of::Index motion, bool distrusted,
            double dt) noexcept {
  add_sample(deviation.filter, state.time_ns, state.mean[index], 0.0, false);
  const double off = deviation.filter.mean() - others.motion[motion];
  deviation.sum =
      std::abs(off) > onset_sigmas * others.sigma[motion] ? deviation.sum + off * dt : 0.0;
  return !std::exchange(deviation.distrusted, distrusted) && distrusted;
}

/// Sets a motion to that by the consensus, and what drives it to nothing known.
void reset(State& state, Deviation& deviation, at::Index index, double value, double sigma,
           at::Index driver, double driver_sigma) noexcept {
  state.mean[index] = value;
  state.mean[driver] = 0.0;
  forget(state, index, sigma);
  forget(state, driver, driver_sigma);
  deviation.filter = {};
  deviation.since_ns = 0;
}

}  // namespace

void apply_integrity(const Context& context, State& state) noexcept {
  const std::int64_t checked_ns = state.integrity.checked_ns();
  state.integrity.set_sensor_errors(
      {.gyro_bias = state.slow.mean[slow::gyro_bias],
       .gyro_bias_sigma = std::sqrt(state.slow.covariance(slow::gyro_bias, slow::gyro_bias)),
       .steering_offset = state.mean[at::steering_offset],
       .steering_offset_sigma =
           std::sqrt(state.covariance(at::steering_offset, at::steering_offset)),
       .wheel_slip = std::abs(state.slow.mean[slow::wheel_slip]) +
                     std::sqrt(state.slow.covariance(slow::wheel_slip, slow::wheel_slip)),
       .camera_noise_scale = state.camera_noise_scale,
       .gyro_latency = std::abs(state.slow.mean[slow::gyro_latency] -
                                state.readings[index_of(Source::yaw_rate)].advanced_s) +
                       std::sqrt(state.slow.covariance(slow::gyro_latency, slow::gyro_latency)),
       .dead_band = state.standstill.dead_band});
  state.integrity.check(context.sensors, state.time_ns);
  const double dt = seconds_between(checked_ns, state.integrity.checked_ns());
  if (checked_ns == 0 || dt <= 0.0) {
    return;
  }
  const Integrity::Agreed& agreed = state.integrity.agreed();
  const auto mark_doubtful = [&state] {
    state.doubtful = true;
    state.confirming_poses = 0;
  };
  const bool gyro_distrusted = !state.integrity.trusted(Source::yaw_rate);
  if (gyro_distrusted ||
      (agreed.contradicted &&
       seconds_between(agreed.contradicted_since_ns, state.time_ns) >= contradicted_s)) {
    mark_doubtful();
  }
  if (!gyro_alive(state)) {
    state.turn_noise_scale = 1.0;
  }
  auto& [speed_off, turn_off] = state.deviations;
  if (!state.moving) {
    state.deviations = {};
    return;
  }
  const Eigen::Matrix<double, 6, 6> P = covariance_of_motion(state);
  // 1. Take back what a faulty source has done to the pose since its disagreement began.
  const bool gyro_failed =
      follow(state, turn_off, at::yaw_rate, agreed.without_gyro, of::yaw_rate, gyro_distrusted, dt);
  const bool wheels_failed = follow(state, speed_off, at::v_x, agreed.without_wheels, of::speed,
                                    agreed.wheels_distrusted, dt);
  const double uncertain = squared(context.model.tuning.fault_share);
  const auto take_back = [&](double distance) {
    mark_doubtful();
    const Eigen::Vector2d way = state.along_heading(distance);
    state.mean.head<2>() -= way;
    state.covariance.topLeftCorner<2, 2>() += uncertain * way * way.transpose();
  };
  if (gyro_failed) {
    state.mean[at::yaw] -= turn_off.sum;
    state.covariance(at::yaw, at::yaw) += uncertain * squared(turn_off.sum);
  }
  if (wheels_failed) {
    // A camera that sees the car has corrected the pose already.
    const double unseen_s =
        seconds_between(state.fused_ns[index_of(Source::camera)], state.time_ns);
    take_back(unseen_s < contradicted_s ? 0.0 : speed_off.sum);
  }
  if (agreed.reversed_distance != 0.0) {
    take_back(2.0 * agreed.reversed_distance);
  }
  // 2. Reset the motion to the consensus where it deviates.
  const integrity::Solution& all = state.integrity.motion();
  const auto lasts = [&](Deviation& deviation, double off, double sigma, double variance) {
    if (std::abs(off) <= deviation_sigmas * std::sqrt(sigma * sigma + variance) ||
        agreed.contradicted) {
      deviation.since_ns = 0;
      return false;
    }
    deviation.since_ns = deviation.since_ns == 0 ? checked_ns : deviation.since_ns;
    return seconds_between(deviation.since_ns, state.time_ns) >= deviation_s;
  };
  const double speed = all.motion[of::speed];
  const double faster = speed - speed_off.filter.mean();
  if (lasts(speed_off, faster, all.sigma[of::speed], P(3, 3)) || wheels_failed) {
    if (state.standstill.standing) {
      set_off(context.model, state, speed);
    }
    const Eigen::Vector2d way = state.along_heading(faster * deviation_s);
    state.covariance.topLeftCorner<2, 2>() += way * way.transpose();
    reset(state, speed_off, at::v_x, speed, all.sigma[of::speed], at::accel_x,
          context.model.tuning.drive_accel * gravity);
  }
  if (state.standstill.standing) {
    return;  // the gyro measures its bias
  }
  const double yaw_rate = all.motion[of::yaw_rate];
  const double turning = yaw_rate - turn_off.filter.mean();
  if (lasts(turn_off, turning, all.sigma[of::yaw_rate], P(5, 5)) || gyro_failed) {
    state.covariance(at::yaw, at::yaw) += squared(turning * deviation_s);
    reset(state, turn_off, at::yaw_rate, yaw_rate, all.sigma[of::yaw_rate], at::front_angle,
          context.model.tuning.front_angle);
    state.turned_since_ns = 0;
  }
}

}  // namespace odomd::estimator::full
