// docs/model.md, "Publication".
#include "estimator/ekf/publication.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>

#include "estimator/common/pose.hpp"
#include "estimator/common/predecessor.hpp"
#include "estimator/common/symmetric3.hpp"
#include "estimator/common/time.hpp"
#include "estimator/ekf/update.hpp"
#include "estimator/integrity/admission.hpp"

namespace odomd::estimator::full {

namespace {

// Beyond any car and sensor; larger numbers might overflow.
constexpr double largest_position = 2.0 * largest_coordinate;
constexpr double largest_state = 1e4;

/// Beyond a deviation of a kilometre, half a turn or 100 m/s nothing is known.
const Vector largest_deviation = [] {
  constexpr double yaw = 3.2;
  constexpr double speed = 100.0;
  constexpr double accel = 50.0;
  constexpr double bias = 10.0;
  return Vector{{largest_camera_sigma, largest_camera_sigma, yaw, speed, speed,
                 physical_limit[index_of(Source::yaw_rate)], accel, 1.0, accel, bias, bias, 0.5}};
}();
const SlowVector largest_error =
    SlowVector::NullaryExpr([](Eigen::Index i) { return slow_priors.begin()[i].highest; });

// A calibration is valid once its sigma has shrunk to this share of the initial sigma.
constexpr double learnt_share = 0.4;

// The published time derivatives are means over this time [s].
constexpr double look_ahead_s = 0.06;

/// Index of a calibration among slow errors or states, and its published value if the error is 0.
struct Calibrated {
  bool is_slow;
  Eigen::Index index;
  double neutral = 0.0;
  bool is_grip = false;  ///< μ = 1 / (1/μ_0 + softness) is published, ∂μ/∂softness = -μ²
};

/// In the order of Calibration.
constexpr auto calibrated = std::to_array<Calibrated>({
    {true, slow::gyro_bias},
    {true, slow::gyro_scale, 1.0},
    {false, at::accel_bias_x},
    {false, at::accel_bias_y},
    {true, slow::wheel_scale, 1.0},
    {false, at::steering_offset},
    {true, slow::stiffness_scale, 1.0},
    {true, slow::gyro_latency},
    {true, slow::wheel_latency},
    {true, slow::steering_latency},
    {true, slow::softness, 0.0, true},
});
static_assert(calibrated.size() == calibration_count);

double neutral_of(const CarModel& model, const Calibrated& c) noexcept {
  return c.is_grip ? usual_softness(model.car.grip_rear) : c.neutral;
}

/// For const and non-const states.
auto& value_of(auto& state, const Calibrated& c) noexcept {
  return c.is_slow ? state.slow.mean[c.index] : state.mean[c.index];
}
auto& variance_of(auto& state, const Calibrated& c) noexcept {
  return c.is_slow ? state.slow.covariance(c.index, c.index) : state.covariance(c.index, c.index);
}

Calibration calibration_of(const CarModel& model, const State& state,
                           const State& initial) noexcept {
  constexpr double least_softness = 1e-3;
  Calibration calibration;
  for (std::size_t i = 0; i < calibrated.size(); ++i) {
    const Calibrated& c = calibrated[i];
    const double variance = variance_of(state, c);
    const double known = value_of(state, c) + neutral_of(model, c);
    const double value = c.is_grip ? 1.0 / std::max(known, least_softness) : known;
    calibration.value[i] = value;
    calibration.sigma[i] = (c.is_grip ? squared(value) : 1.0) * std::sqrt(variance);
    const bool significant = !c.is_grip || squared(1.0 / value) > squared(2.0) * variance;
    if (significant && variance < squared(learnt_share) * variance_of(initial, c)) {
      calibration.valid |= std::uint64_t{1} << i;
    }
  }
  return calibration;
}

/// The mean rate over the next 60 ms, in which the tyres settle. A client integrates it for up to
/// 100 ms; the present rate would deviate from the filter's own propagation.
Eigen::Vector3d mean_rate_ahead(const CarModel& model, const Input& input, double period_s,
                                const State& state) noexcept {
  const long steps = std::max(1L, std::lround(look_ahead_s / period_s));
  return (velocity_after(model, moving(state, input), look_ahead_s, steps) -
          state.mean.segment<3>(at::v_x)) /
         look_ahead_s;
}

}  // namespace

void limit(State& state) noexcept {
  state.covariance.diagonal() *= rounding_inflation;
  state.slow.covariance.diagonal() *= rounding_inflation;
  estimator::limit(state.covariance, largest_deviation);
  estimator::limit(state.slow.covariance, largest_error);
  for (Eigen::Index j = 0; j < slow::size; ++j) {
    const Vector most = 1.0 / std::sqrt(state.slow.covariance(j, j)) * largest_deviation;
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
  SlowVector slow_sigma =
      SlowVector::NullaryExpr([&t](Eigen::Index i) { return t.*slow_priors.begin()[i].sigma; });
  state.standstill.dead_band = settings.dead_band;
  std::ranges::replace(state.standstill.dead_band, 0.0, t.dead_band * settings.vehicle.wheelbase());
  for (const auto& [index, configured] :
       {std::pair{slow::roll_gradient, settings.roll_gradient},
        std::pair{slow::pitch_gradient, settings.pitch_gradient}}) {
    if (configured) {
      state.slow.mean[index] = *configured;
      slow_sigma[index] *= third;
    }
  }
  state.slow.covariance.diagonal() = slow_sigma.array().square();
  return state;
}

Estimate publication(const CarModel& model, const Input& input, double period_s, const State& state,
                     const State& initial) noexcept {
  const Vector& x = state.mean;
  Eigen::Matrix<double, 6, 6> P = covariance_of_motion(state);
  const double way = state.disputed.head<2>().squaredNorm() + state.lasting_way.variance;
  const double turn = squared(state.disputed[2]) + state.lasting_turn.variance;
  P.diagonal().head<3>() += Eigen::Vector3d(way, way, turn);
  if (state.unconfirmed) {
    // The only camera pose so far may be an outlier.
    const double range = model.tuning.outlier_range * model.car.wheelbase();
    P.diagonal().head<3>() +=
        model.tuning.outlier_share * Eigen::Vector3d(range, range, std::numbers::pi).cwiseAbs2();
  }
  // With unsigned wheel speeds, the car may have halted and reversed since the last pose.
  const double unseen_s = seconds_between(state.reading(Source::camera).fused_ns, state.time_ns);
  const double backwards = std::clamp(std::abs(x[at::v_x]) * unseen_s, 0.0,
                                      std::abs(state.integrity.agreed().unsigned_distance));
  if (backwards > 0.0) {
    Eigen::Vector<double, 6> reversed;
    reversed << state.along_heading(backwards), 0.0, x[at::v_x], 0.0, 0.0;
    reversed *= model.tuning.reversing;
    P += reversed * reversed.transpose();
  }
  if (state.last_camera_pose.capture_ns != 0) {
    // The filter follows the camera's clock: if that is late by τ_c, so is the pose. A
    // predecessor's covariance contains this already.
    Eigen::Vector3d late;
    late << Eigen::Rotation2Dd(x[at::yaw]) * x.segment<2>(at::v_x), x[at::yaw_rate];
    late *= model.tuning.camera_latency;
    P.topLeftCorner<3, 3>() += late * late.transpose();
  }
  Estimate e;
  e.time_ns = state.time_ns;
  e.initialised = state.located && state.moving;
  e.map = state.pose();
  e.v_x = x[at::v_x];
  e.v_y = x[at::v_y];
  e.yaw_rate = x[at::yaw_rate];
  e.covariance = packed(P.topLeftCorner<3, 3>());
  e.velocity_covariance = packed(P.bottomRightCorner<3, 3>());
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(e.cross_covariance.data()) =
      P.topRightCorner<3, 3>();
  e.accel_x = state.accel_x.value;
  e.accel_y = state.accel_y.value;
  e.steering = state.steering.value;
  e.camera_ns = state.reading(Source::camera).fused_ns;
  e.camera_test_ratio = state.camera_test_ratio;
  e.calibration = calibration_of(model, state, initial);
  const auto implausible = [&](slow::Index scale) {
    return std::abs(state.slow.mean[scale]) > most_sigmas * initial.sigma(scale);
  };
  // The bias counts as unlearnt unless a camera or a standstill shows it.
  constexpr double longest_unseen_s = 0.5;
  e.bias_unlearnt = e.initialised && !state.standstill.wheels_still &&
                    (e.calibration.valid & 1U) == 0 &&
                    state.reading(Source::yaw_rate).fused_ns != 0 &&
                    (e.camera_ns == 0 || unseen_s > longest_unseen_s);
  e.scale_implausible = implausible(slow::gyro_scale) || implausible(slow::wheel_scale);
  if (e.initialised && !state.standstill.standing) {
    const Eigen::Vector3d rate = mean_rate_ahead(model, input, period_s, state);
    e.v_x_dot = rate[0];
    e.v_y_dot = rate[1];
    e.yaw_accel = rate[2];
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
    const double published = known.value[i];
    const double value = (c.is_grip ? 1.0 / published : published) - neutral_of(model, c);
    const double sigma = known.sigma[i] / (c.is_grip ? squared(published) : 1.0);
    if (std::isfinite(value) && (!c.is_grip || published > 0.0) && sigma > 0.0 &&
        squared(sigma) < variance_of(state, c)) {
      value_of(state, c) = value;
      variance_of(state, c) = squared(sigma);
    }
  }
  state.reading(Source::camera).fused_ns = predecessor.camera_ns;
  state.located = true;
  state.moving = true;
  return state;
}

void bridge_gap(State& state, double gap_s) noexcept {
  const double gone = gap_s * std::hypot(state.mean[at::v_x], state.mean[at::v_y]);
  const double turned = gap_s * state.mean[at::yaw_rate];
  auto variances = state.covariance.diagonal();
  variances.head<3>() +=
      gap_noise(0.5 * gap_s * gap_s) + Eigen::Vector3d(gone, gone, turned).cwiseAbs2();
  variances.segment<3>(at::v_x) += gap_noise(gap_s);
  state.standstill = {.dead_band = state.standstill.dead_band};
  limit(state);
}

}  // namespace odomd::estimator::full
