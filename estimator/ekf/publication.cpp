#include "estimator/ekf/publication.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/common/pose.hpp"
#include "estimator/common/predecessor.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/ekf/model.hpp"

namespace odomd::estimator::full {
namespace {

/// The states that a Calibration tells of, in its order, and what it adds to them.
struct Calibrated {
  at::Index state;
  double neutral;
};
constexpr std::array<Calibrated, calibration_count> calibrated{{{at::gyro_bias, 0.0},
                                                                {at::gyro_scale, 1.0},
                                                                {at::accel_bias_x, 0.0},
                                                                {at::accel_bias_y, 0.0},
                                                                {at::wheel_scale, 1.0},
                                                                {at::steering_offset, 0.0},
                                                                {at::stiffness_scale, 1.0}}};
// Learnt is what is known so much better than at first.
constexpr double learnt_share = 0.4;

// So far ahead look the published time derivatives [s].
constexpr double look_ahead_s = 0.06;

Calibration calibration_of(const State& state, const Vector& prior_sigma) noexcept {
  Calibration calibration;
  for (std::size_t i = 0; i < calibration_count; ++i) {
    const auto [index, neutral] = calibrated[i];
    calibration.value[i] = state.mean[index] + neutral;
    calibration.sigma[i] = std::sqrt(state.covariance(index, index));
    if (calibration.sigma[i] < learnt_share * prior_sigma[index]) {
      calibration.valid |= std::uint64_t{1} << i;
    }
  }
  return calibration;
}

/// What a client integrates for up to 100 ms: the mean rate of the next 60 ms, in which the tyres
/// settle. The rate of this instant would run away from the filter's own propagation.
BodyVelocity mean_rate_ahead(const Context& context, const State& state) noexcept {
  const Input input = input_of(state);
  const Eigen::Vector3d now = state.mean.segment<3>(at::v_x);
  Eigen::Matrix<double, 8, 1> ahead = state.mean.segment<8>(at::v_x);
  const long steps = std::max(1L, std::lround(look_ahead_s / context.period_s));
  const double dt = look_ahead_s / static_cast<double>(steps);
  for (long done = 0; done < steps; ++done) {
    ahead.head<3>() = next_velocity<double>(context.model, input, ahead, dt);
  }
  return {(ahead[0] - now[0]) / look_ahead_s, (ahead[1] - now[1]) / look_ahead_s,
          (ahead[2] - now[2]) / look_ahead_s};
}

Eigen::Matrix3d unpacked(const Symmetric3& s) noexcept {
  Eigen::Matrix3d m;
  m << s[0], s[1], s[2],  //
      s[1], s[3], s[4],   //
      s[2], s[4], s[5];
  return m;
}

}  // namespace

Vector prior_sigma(const FilterSettings& settings) noexcept {
  const std::array<double, at::size> sigma{
      settings.initial_sigma_position,
      settings.initial_sigma_position,
      settings.initial_sigma_yaw,  //
      1.0,
      0.5,
      1.0,   // v_x, v_y [m/s], yaw_rate [rad/s]
      1.5,   // front_force [m/s²]
      1.5,   // yaw_moment [rad/s²]
      0.3,   // accel_bias_x [m/s²]
      0.02,  // steering_offset [rad]
      0.15,  // stiffness_scale
      0.03,  // gyro_bias [rad/s]
      0.02,  // gyro_scale
      0.3,   // accel_bias_y [m/s²]
      0.03,  // wheel_scale
  };
  return Vector(sigma.data());
}

Estimate publication(const Context& context, const State& state,
                     const Vector& prior_sigma) noexcept {
  const Vector& x = state.mean;
  const Matrix& P = state.covariance;
  Estimate e;
  e.time_ns = state.time_ns;
  e.initialised = state.located && state.moving;
  e.map = state.pose();
  e.v_x = x[at::v_x];
  e.v_y = x[at::v_y];
  e.yaw_rate = x[at::yaw_rate];
  e.covariance = {P(0, 0), P(0, 1), P(0, 2), P(1, 1), P(1, 2), P(2, 2)};
  e.velocity_covariance = {P(3, 3), P(3, 4), P(3, 5), P(4, 4), P(4, 5), P(5, 5)};
  for (std::size_t i = 0; i < 9; ++i) {
    e.cross_covariance[i] =
        P(static_cast<Eigen::Index>(i / 3), 3 + static_cast<Eigen::Index>(i % 3));
  }
  e.accel_x = state.accel_x.value;
  e.accel_y = state.accel_y.value;
  e.steering = state.steering.value;
  e.camera_ns = state.fused_ns[index_of(Source::camera)];
  e.camera_test_ratio = state.camera_test_ratio;
  e.calibration = calibration_of(state, prior_sigma);
  if (e.initialised && !state.rest.standing) {
    const BodyVelocity rate = mean_rate_ahead(context, state);
    e.v_x_dot = rate.v_x;
    e.v_y_dot = rate.v_y;
    e.yaw_accel = rate.yaw_rate;
  }
  return e;
}

State resumed(const Estimate& predecessor, double gap_s, const Vector& prior_sigma) noexcept {
  State state;
  // The car has most likely gone on as it went.
  const BodyVelocity velocity = velocity_of(predecessor);
  const Pose2 map = moved(predecessor.map, velocity, gap_s);
  state.mean.segment<3>(at::x) << map.x, map.y, map.yaw;
  state.mean.segment<3>(at::v_x) << velocity.v_x, velocity.v_y, velocity.yaw_rate;

  // P ← F P Fᵀ + τ² G V Gᵀ and what the gap adds: an error of the velocity lasts as long as the
  // gap.
  const Symmetric3 V = velocity_covariance_of(predecessor);
  const double c = std::cos(predecessor.map.yaw);
  const double s = std::sin(predecessor.map.yaw);
  const Symmetric3 P =
      sum(displaced(predecessor.covariance, map.x - predecessor.map.x, map.y - predecessor.map.y),
          scaled(rotated(V, c, s), gap_s * gap_s));
  state.covariance.diagonal() = prior_sigma.array().square();
  state.covariance.topLeftCorner<3, 3>() = unpacked(sum(P, gap_noise(gap_s)));
  state.covariance.block<3, 3>(at::v_x, at::v_x) = unpacked(sum(V, velocity_gap_noise(gap_s)));

  const Calibration& known = predecessor.calibration;
  for (std::size_t i = 0; i < calibration_count; ++i) {
    const auto [index, neutral] = calibrated[i];
    const double value = known.value[i] - neutral;
    const double sigma = known.sigma[i];
    if (std::isfinite(value) && sigma > 0.0 && sigma < prior_sigma[index]) {
      state.mean[index] = value;
      state.covariance(index, index) = sigma * sigma;
    }
  }
  state.fused_ns[index_of(Source::camera)] = predecessor.camera_ns;
  state.located = true;
  state.moving = true;
  return state;
}

}  // namespace odomd::estimator::full
