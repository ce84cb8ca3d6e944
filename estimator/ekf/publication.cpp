// docs/model.md, "Publication".
#include "estimator/ekf/publication.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "estimator/common/pose.hpp"
#include "estimator/common/predecessor.hpp"
#include "estimator/common/squares.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/common/vehicle.hpp"
#include "estimator/common/wheel_place.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

namespace {

// Beyond any car and sensor; larger numbers might overflow.
constexpr double largest_position = 1e9;
constexpr double largest_state = 1e4;

/// Larger deviations mean that nothing is known: half a turn, a kilometre, 100 m/s.
const Vector largest_deviation{{1e3, 1e3, 3.2, 1e2, 1e2, 35.0, 50.0, 1.0, 50.0, 10.0, 10.0, 0.5}};
const SlowVector largest_slow_error{{1.0, 0.5, 0.5, 0.1, 0.9, 1.0, 1.0, 0.3, 0.3, 0.3, 0.1, 1.0}};

/// P = L Lᵀ. A NaN or infinity anywhere in P makes some element of L's diagonal not finite.
template <typename Covariance>
bool is_positive_definite(const Covariance& P) noexcept {
  const Eigen::LLT<Covariance> factors(P);
  return factors.info() == Eigen::Success && factors.matrixLLT().diagonal().allFinite();
}

template <int Size>
void limit(Eigen::Matrix<double, Size, Size>& P,
           const Eigen::Matrix<double, Size, 1>& largest) noexcept {
  P.diagonal() *= rounding_inflation;
  for (Eigen::Index i = 0; i < Size; ++i) {
    if (P(i, i) > largest[i] * largest[i]) {
      const double factor = largest[i] / std::sqrt(P(i, i));
      P.row(i) *= factor;
      P.col(i) *= factor;
    }
  }
}

// A calibration is valid once its sigma has shrunk to this share.
constexpr double learnt_share = 0.4;

// Sigma of a configured gradient relative to an unknown one.
constexpr double configured_share = 1.0 / 3.0;

// The published time derivatives are means over this time [s].
constexpr double look_ahead_s = 0.06;

/// Place of a calibration among slow errors or states, and its published value for no error.
struct Calibrated {
  bool is_slow;
  Eigen::Index index;
  double neutral;
};

/// In the order of Calibration, but for its last: the grip μ, of which the filter knows 1/μ.
constexpr auto calibrated = std::to_array<Calibrated>({
    {true, slow::gyro_bias, 0.0},
    {true, slow::gyro_scale, 1.0},
    {false, at::accel_bias_x, 0.0},
    {false, at::accel_bias_y, 0.0},
    {true, slow::wheel_scale, 1.0},
    {false, at::steering_offset, 0.0},
    {true, slow::stiffness_scale, 1.0},
    {true, slow::gyro_latency, 0.0},
    {true, slow::wheel_latency, 0.0},
    {true, slow::steering_latency, 0.0},
});
static_assert(calibrated.size() + 1 == calibration_count);
constexpr std::size_t grip = calibrated.size();
constexpr double least_softness = 1e-3;

/// For const and non-const states.
auto& value_of(auto& state, const Calibrated& c) noexcept {
  return c.is_slow ? state.slow.mean[c.index] : state.mean[c.index];
}
auto& variance_of(auto& state, const Calibrated& c) noexcept {
  return c.is_slow ? state.slow.covariance(c.index, c.index) : state.covariance(c.index, c.index);
}

Calibration calibration_of(const CarModel& model, const State& state,
                           const State& initial) noexcept {
  Calibration calibration;
  for (std::size_t i = 0; i < calibrated.size(); ++i) {
    const Calibrated& c = calibrated[i];
    const double variance = variance_of(state, c);
    calibration.value[i] = value_of(state, c) + c.neutral;
    calibration.sigma[i] = std::sqrt(variance);
    if (variance < learnt_share * learnt_share * variance_of(initial, c)) {
      calibration.valid |= std::uint64_t{1} << i;
    }
  }
  // μ = 1 / (1/μ_0 + softness), ∂μ/∂softness = -μ²
  const double variance = state.slow.covariance(slow::softness, slow::softness);
  calibration.value[grip] =
      1.0 / std::max(usual_softness(model.car.grip_rear) + state.slow.mean[slow::softness],
                     least_softness);
  calibration.sigma[grip] = squared(calibration.value[grip]) * std::sqrt(variance);
  const double softness = 1.0 / calibration.value[grip];
  if (variance < squared(learnt_share) * initial.slow.covariance(slow::softness, slow::softness) &&
      squared(softness) > 4.0 * variance) {
    calibration.valid |= std::uint64_t{1} << grip;
  }
  return calibration;
}

/// A client integrates the derivatives for up to 100 ms: the mean rate of the next 60 ms, in which
/// the tyres settle. The present rate would deviate from the filter's own propagation.
BodyVelocity mean_rate_ahead(const CarModel& model, const Input& input, double period_s,
                             const State& state) noexcept {
  const long steps = std::max(1L, std::lround(look_ahead_s / period_s));
  const Eigen::Vector3d change = velocity_after(model, moving(state, input), look_ahead_s, steps) -
                                 state.mean.segment<3>(at::v_x);
  return {change[0] / look_ahead_s, change[1] / look_ahead_s, change[2] / look_ahead_s};
}

}  // namespace

void limit(State& state) noexcept {
  limit(state.covariance, largest_deviation);
  limit(state.slow.covariance, largest_slow_error);
  for (Eigen::Index j = 0; j < slow::size; ++j) {
    const Vector most = largest_deviation / std::sqrt(state.slow.covariance(j, j));
    state.slow.sensitivity.col(j) = state.slow.sensitivity.col(j).cwiseMax(-most).cwiseMin(most);
  }
}

bool is_valid(const State& state) noexcept {
  return state.mean.allFinite() && state.mean.head<2>().cwiseAbs().maxCoeff() < largest_position &&
         state.mean.tail<at::size - 3>().cwiseAbs().maxCoeff() < largest_state &&
         state.mean.segment<2>(at::v_x).cwiseAbs().maxCoeff() < fastest &&
         std::abs(state.mean[at::yaw_rate]) < fastest_turn && state.slow.mean.allFinite() &&
         state.slow.mean.cwiseAbs().maxCoeff() < largest_state &&
         state.slow.sensitivity.allFinite() && is_positive_definite(state.covariance) &&
         is_positive_definite(state.slow.covariance);
}

State initial_state(const FilterSettings& settings) noexcept {
  const Tuning& t = settings.tuning;
  State state;
  Vector sigma;
  sigma << initial_sigma, initial_sigma, initial_sigma, 1.0, 0.5,
      1.0,  // v_x, v_y [m/s], yaw_rate [rad/s]
      t.drive_accel * gravity, t.front_angle, t.side_force_floor * gravity, t.accel_bias,
      t.accel_bias, t.steering_offset;
  state.covariance.diagonal() = sigma.array().square();
  SlowVector slow_sigma;
  slow_sigma << t.gyro_bias, t.gyro_scale, t.wheel_scale, t.wheel_slip, t.stiffness_scale,
      t.roll_gradient, t.pitch_gradient, t.latency, t.latency, t.latency, t.wheel_difference,
      t.softness;
  double& dead_band = state.standstill.dead_band;
  dead_band = t.dead_band * settings.vehicle.wheelbase();
  for (const Source wheel : wheel_sources) {
    if (settings.dead_band[index_of(wheel)] > 0.0) {
      dead_band = settings.dead_band[index_of(wheel)];
    }
  }
  for (const auto& [index, configured] :
       {std::pair{slow::roll_gradient, settings.roll_gradient},
        std::pair{slow::pitch_gradient, settings.pitch_gradient}}) {
    if (configured) {
      state.slow.mean[index] = *configured;
      slow_sigma[index] *= configured_share;
    }
  }
  state.slow.covariance.diagonal() = slow_sigma.array().square();
  return state;
}

Estimate publication(const CarModel& model, const Input& input, double period_s, const State& state,
                     const State& initial) noexcept {
  const Vector& x = state.mean;
  Eigen::Matrix<double, 6, 6> P = covariance_of_motion(state);
  const Disputed disputed = state.disputed.at_time(state.time_ns, model.tuning.disputed_s);
  const double way = disputed.way + state.lasting_way.variance;
  P.diagonal().head<3>() += Eigen::Vector3d(way, way, disputed.turn + state.lasting_turn.variance);
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
  e.calibration = calibration_of(model, state, initial);
  const auto implausible = [&](slow::Index scale) {
    constexpr double sigmas = 3.0;
    return std::abs(state.slow.mean[scale]) >
           sigmas * std::sqrt(initial.slow.covariance(scale, scale));
  };
  // A camera or a standing car will teach it.
  constexpr double unseen_s = 0.5;
  e.bias_unlearnt = e.initialised && !state.standstill.wheels_still &&
                    (e.calibration.valid & 1U) == 0 &&
                    state.fused_ns[index_of(Source::yaw_rate)] != 0 &&
                    (e.camera_ns == 0 || seconds_between(e.camera_ns, state.time_ns) > unseen_s);
  e.scale_implausible = implausible(slow::gyro_scale) || implausible(slow::wheel_scale);
  if (e.initialised && !state.standstill.standing) {
    const BodyVelocity rate = mean_rate_ahead(model, input, period_s, state);
    e.v_x_dot = rate.v_x;
    e.v_y_dot = rate.v_y;
    e.yaw_accel = rate.yaw_rate;
  }
  return e;
}

State resumed(const CarModel& model, const Estimate& predecessor, double gap_s,
              const State& initial) noexcept {
  State state = initial;
  const Estimate now = after_gap(predecessor, gap_s);
  state.mean.head<6>() << now.map.x, now.map.y, now.map.yaw, now.v_x, now.v_y, now.yaw_rate;
  state.covariance.topLeftCorner<3, 3>() = unpacked(now.covariance);
  state.covariance.block<3, 3>(at::v_x, at::v_x) = unpacked(now.velocity_covariance);

  const Calibration& known = predecessor.calibration;
  for (std::size_t i = 0; i < calibrated.size(); ++i) {
    const Calibrated& c = calibrated[i];
    const double value = known.value[i] - c.neutral;
    const double variance = known.sigma[i] * known.sigma[i];
    if (std::isfinite(value) && variance > 0.0 && variance < variance_of(state, c)) {
      value_of(state, c) = value;
      variance_of(state, c) = variance;
    }
  }
  const double softness_sigma = known.sigma[grip] / squared(known.value[grip]);
  double& softness_variance = state.slow.covariance(slow::softness, slow::softness);
  if (known.value[grip] > 0.0 && softness_sigma > 0.0 &&
      squared(softness_sigma) < softness_variance) {
    state.slow.mean[slow::softness] = 1.0 / known.value[grip] - usual_softness(model.car.grip_rear);
    softness_variance = squared(softness_sigma);
  }
  state.fused_ns[index_of(Source::camera)] = predecessor.camera_ns;
  state.located = true;
  state.moving = true;
  return state;
}

void bridge_gap(State& state, double gap_s) noexcept {
  const Symmetric3 way = gap_noise(gap_s);
  const Symmetric3 change = velocity_gap_noise(gap_s);
  const double gone = gap_s * std::hypot(state.mean[at::v_x], state.mean[at::v_y]);
  const double turned = gap_s * state.mean[at::yaw_rate];
  Eigen::Matrix<double, 6, 1> more;
  more << way[0] + gone * gone, way[3] + gone * gone, way[5] + turned * turned, change[0],
      change[3], change[5];
  state.covariance.diagonal().head<6>() += more;
  state.standstill = {.dead_band = state.standstill.dead_band};
  limit(state);
}

}  // namespace odomd::estimator::full
