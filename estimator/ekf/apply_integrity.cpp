// docs/model.md, "Integrity".
#include "estimator/ekf/take.hpp"

#include <cmath>
#include <utility>

#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/judge.hpp"
#include "estimator/ekf/plausibility.hpp"
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
// The pose becomes doubtful once sources contradict each other for this long.
constexpr double contradicted_s = 0.25;

}  // namespace

void apply_integrity(const Context& context, State& state) noexcept {
  if (!state.integrity.is_due(state.time_ns)) {
    return;
  }
  const std::int64_t checked_ns = state.integrity.checked_ns();
  const Eigen::Matrix<double, 6, 6> P = covariance_of_motion(state);
  const Eigen::Vector2d rear{1.0, -context.model.car.rear_axle};  // v_y - l_h ψ̇
  const integrity::SensorErrors errors{
      .gyro_bias = state.slow.mean[slow::gyro_bias],
      .gyro_bias_sigma = state.sigma(slow::gyro_bias),
      .steering_offset = state.mean[at::steering_offset],
      .steering_offset_sigma = std::sqrt(state.variance(at::steering_offset)),
      .wheel_slip = std::abs(state.slow.mean[slow::wheel_slip]) + state.sigma(slow::wheel_slip),
      .camera_noise_scale = state.camera_noise_scale,
      .rear_slip = rear.dot(state.mean.segment<2>(at::v_y)),
      .rear_slip_sigma = std::sqrt(rear.dot(P.block<2, 2>(at::v_y, at::v_y) * rear)),
      .speed_known = knows_speed(context.model.car.driven, state),
      .gyro_latency = std::abs(state.slow.mean[slow::gyro_latency] -
                               state.reading(Source::yaw_rate).advanced_s) +
                      state.sigma(slow::gyro_latency),
      .dead_band = state.standstill.dead_band};
  state.integrity.check(context.model, state.time_ns, errors);
  const double dt = seconds_between(checked_ns, state.time_ns);
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
  if (!state.moving || checked_ns == 0) {
    state.of_speed = state.of_yaw_rate = {};
    return;
  }
  // 1. Undo a faulty source's effect on the pose since its disagreement began.
  const auto fails = [&](Deviation& deviation, double now, const integrity::Solution& others,
                         of::Index index, bool distrusted) {
    add_sample(deviation.filter, state.time_ns, now, 0.0, false);
    const double off = deviation.filter.mean() - others.motion[index];
    deviation.sum =
        std::abs(off) > onset_sigmas * others.sigma[index] ? deviation.sum + off * dt : 0.0;
    return !std::exchange(deviation.distrusted, distrusted) && distrusted;
  };
  Deviation& turn = state.of_yaw_rate;
  Deviation& drive = state.of_speed;
  const bool gyro_failed =
      fails(turn, state.mean[at::yaw_rate], agreed.without_gyro, of::yaw_rate, gyro_distrusted);
  const bool wheels_failed =
      fails(drive, state.mean[at::v_x], agreed.without_wheels, of::speed, agreed.wheels_distrusted);
  const double uncertain = squared(context.model.tuning.fault_share);
  const auto take_back = [&](double distance) {
    mark_doubtful();
    const Eigen::Vector2d way = state.along_heading(distance);
    state.mean.head<2>() -= way;
    state.covariance.topLeftCorner<2, 2>() += uncertain * way * way.transpose();
  };
  if (gyro_failed) {
    state.mean[at::yaw] -= turn.sum;
    state.variance(at::yaw) += uncertain * turn.sum * turn.sum;
  }
  // A camera that sees the car has already corrected the pose.
  const bool seen =
      seconds_between(state.reading(Source::camera).fused_ns, state.time_ns) < contradicted_s;
  if (wheels_failed) {
    take_back(seen ? 0.0 : drive.sum);
  }
  if (agreed.reversed_distance != 0.0) {
    take_back(2.0 * agreed.reversed_distance);
  }
  const double reversing = seen ? 0.0 : context.model.tuning.reversing;
  const Eigen::Vector2d reversed = state.along_heading(reversing * agreed.unsettled_distance);
  state.covariance.topLeftCorner<2, 2>() += reversed * reversed.transpose();
  // 2. Reset the motion to the consensus if it deviates from it.
  const integrity::Solution& all = state.integrity.motion();
  const auto lasts = [&](Deviation& deviation, double off, of::Index index, double variance) {
    if (std::abs(off) <= deviation_sigmas * std::sqrt(squared(all.sigma[index]) + variance) ||
        agreed.contradicted) {
      deviation.since_ns = 0;
      return false;
    }
    deviation.since_ns = deviation.since_ns == 0 ? checked_ns : deviation.since_ns;
    return seconds_between(deviation.since_ns, state.time_ns) >= deviation_s;
  };
  const double speed = all.motion[of::speed];
  const double faster = speed - drive.filter.mean();
  if (lasts(drive, faster, of::speed, P(at::v_x, at::v_x)) || wheels_failed) {
    if (state.standstill.standing) {
      set_off(context.model, state, speed);
    }
    const Eigen::Vector2d way = state.along_heading(faster * deviation_s);
    state.covariance.topLeftCorner<2, 2>() += way * way.transpose();
    state.mean[at::v_x] = speed;
    state.mean[at::accel_x] = 0.0;
    forget(state, at::v_x, all.sigma[of::speed]);
    forget(state, at::accel_x, context.model.tuning.drive_accel * gravity);
    drive = {.sum = drive.sum, .distrusted = drive.distrusted};
  }
  if (state.standstill.standing) {
    return;  // at standstill the gyro measures its bias
  }
  const double turning = all.motion[of::yaw_rate] - turn.filter.mean();
  if (lasts(turn, turning, of::yaw_rate, P(at::yaw_rate, at::yaw_rate)) || gyro_failed) {
    state.variance(at::yaw) += squared(turning * deviation_s);
    state.mean[at::yaw_rate] = all.motion[of::yaw_rate];
    state.mean[at::front_angle] = 0.0;
    forget(state, at::yaw_rate, all.sigma[of::yaw_rate]);
    forget(state, at::front_angle, context.model.tuning.front_angle);
    state.turned_since_ns = 0;
    turn = {.sum = turn.sum, .distrusted = turn.distrusted};
  }
}

}  // namespace odomd::estimator::full
