// docs/model.md, "Integrity".
#include "estimator/ekf/heed_sources.hpp"

#include <cmath>
#include <utility>

#include "estimator/common/time.hpp"
#include "estimator/ekf/standstill.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {
namespace {

// The filter is astray that is off what the sources agree on by so many sigmas, for so long.
constexpr double astray_sigmas = 4.0;
constexpr double astray_s = 0.1;
// A source begins to disagree at so many.
constexpr double beginning_sigmas = 1.5;
// For so long the sources contradict each other before the pose is doubted.
constexpr double contradicted_s = 0.25;

}  // namespace

void heed_sources(const Context& context, State& state) noexcept {
  const std::int64_t checked_ns = state.integrity.checked_ns();
  state.integrity.set_sensor_errors(
      {.gyro_bias = state.slow.mean[slow::gyro_bias],
       .gyro_bias_sigma = std::sqrt(state.slow.covariance(slow::gyro_bias, slow::gyro_bias)),
       .steering_offset = state.mean[at::steering_offset],
       .steering_offset_sigma =
           std::sqrt(state.covariance(at::steering_offset, at::steering_offset)),
       .wheel_slip = std::abs(state.slow.mean[slow::wheel_slip]) +
                     std::sqrt(state.slow.covariance(slow::wheel_slip, slow::wheel_slip)),
       .camera_noise_scale = state.camera_noise_scale});
  state.integrity.check(context.sensors, state.time_ns);
  const double dt = seconds_between(checked_ns, state.integrity.checked_ns());
  if (checked_ns == 0 || dt <= 0.0) {
    return;
  }
  const Integrity::Agreed& agreed = state.integrity.agreed();
  const bool gyro_out = !state.integrity.trusted(Source::yaw_rate);
  if (gyro_out || (agreed.contradicted && seconds_between(agreed.contradicted_since_ns,
                                                          state.time_ns) >= contradicted_s)) {
    state.doubtful = true;
    state.confirming = 0;
  }
  if (!gyro_alive(state)) {
    state.turn_noise_scale = 1.0;
  }
  Astray& astray = state.astray;
  if (!state.moving) {
    astray = {};
    return;
  }
  add_sample(astray.speed, state.time_ns, state.mean[at::v_x], 0.0, false, 1e9);
  add_sample(astray.yaw_rate, state.time_ns, state.mean[at::yaw_rate], 0.0, false, 1e9);
  const Eigen::Matrix<double, 6, 6> P = covariance_of_motion(state);
  const auto root = [](double sigma, double variance) {
    return std::sqrt(sigma * sigma + variance);
  };
  // 1. What a source that is at fault has made of the pose, since it began to disagree.
  const auto follow = [&](double& sum, double off, double sigma) {
    sum = std::abs(off) > beginning_sigmas * sigma ? sum + off * dt : 0.0;
  };
  follow(astray.turn, astray.yaw_rate.mean() - agreed.yaw_rate_without_gyro,
         agreed.yaw_rate_without_gyro_sigma);
  follow(astray.way, astray.speed.mean() - agreed.speed_without_wheels,
         agreed.speed_without_wheels_sigma);
  const bool turned = !std::exchange(astray.gyro_out, gyro_out) && gyro_out;
  const bool slipped =
      !std::exchange(astray.wheels_out, agreed.wheels_distrusted) && agreed.wheels_distrusted;
  if (turned) {
    state.mean[at::yaw] -= astray.turn;
    state.covariance(at::yaw, at::yaw) += 0.25 * astray.turn * astray.turn;
  }
  if (slipped) {
    state.doubtful = true;
    state.confirming = 0;
    const double yaw = state.mean[at::yaw];
    const Eigen::Vector2d way = astray.way * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    state.mean.head<2>() -= way;
    state.covariance.topLeftCorner<2, 2>() += 0.25 * way * way.transpose();
  }
  if (agreed.reversed_distance != 0.0) {
    state.doubtful = true;
    state.confirming = 0;
    const double yaw = state.mean[at::yaw];
    const Eigen::Vector2d way =
        agreed.reversed_distance * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    state.mean.head<2>() -= 2.0 * way;
    state.covariance.topLeftCorner<2, 2>() += way * way.transpose();
  }
  // 2. Where the motion is not what the sources agree on, it goes on from there.
  const auto lasts = [&](std::int64_t& since_ns, double off, double sigma) {
    if (std::abs(off) <= astray_sigmas * sigma || agreed.contradicted) {
      since_ns = 0;
      return false;
    }
    since_ns = since_ns == 0 ? checked_ns : since_ns;
    return seconds_between(since_ns, state.time_ns) >= astray_s;
  };
  const double faster = agreed.speed - astray.speed.mean();
  if (lasts(astray.speed_since_ns, faster, root(agreed.speed_sigma, P(3, 3))) || slipped) {
    if (state.standstill.standing) {
      set_off(context.model, state, agreed.speed);
    }
    const double yaw = state.mean[at::yaw];
    const Eigen::Vector2d way = faster * astray_s * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
    state.covariance.topLeftCorner<2, 2>() += way * way.transpose();
    state.mean[at::v_x] = agreed.speed;
    state.mean[at::accel_x] = 0.0;
    forget(state, at::v_x, agreed.speed_sigma);
    forget(state, at::accel_x, context.model.tuning.drive_accel * gravity);
    astray.speed = {};
    astray.speed_since_ns = 0;
  }
  if (state.standstill.standing) {
    return;  // what a gyro says is its bias
  }
  const double turning = agreed.yaw_rate - astray.yaw_rate.mean();
  if (lasts(astray.turn_since_ns, turning, root(agreed.yaw_rate_sigma, P(5, 5))) || turned) {
    const double turn = turning * astray_s;
    state.covariance(at::yaw, at::yaw) += turn * turn;
    state.mean[at::yaw_rate] = agreed.yaw_rate;
    state.mean[at::front_angle] = 0.0;
    forget(state, at::yaw_rate, agreed.yaw_rate_sigma);
    forget(state, at::front_angle, context.model.tuning.front_angle);
    state.turned_since_ns = 0;
    astray.yaw_rate = {};
    astray.turn_since_ns = 0;
  }
}

}  // namespace odomd::estimator::full
