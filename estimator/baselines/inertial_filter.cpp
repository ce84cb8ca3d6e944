#include "estimator/baselines/inertial_filter.hpp"

#include "estimator/baselines/inertial_model.hpp"
#include "estimator/baselines/tick_filter_impl.hpp"

namespace odomd::estimator {
namespace {

// Keep the covariance positive definite: the Jacobian has rank two.
constexpr double floor_speed = 1e-3;     // [m/s]
constexpr double floor_yaw_rate = 1e-3;  // [rad/s]
constexpr double inflation = 1.0 + 1e-6;

Symmetric3 covariance_of(const Vehicle& car, const BodyVelocity& v, double sigma_speed,
                         double sigma_yaw_rate) {
  // J diag(σ_v², σ_ψ̇²) Jᵀ, with J = ∂(v_x, v_y, ψ̇) / ∂(v_x, ψ̇)
  const Eigen::Matrix<double, 3, 2> j = inertial_velocity_jacobian(car, v.v_x, v.yaw_rate);
  const double vv = sigma_speed * sigma_speed;
  const double rr = sigma_yaw_rate * sigma_yaw_rate;
  const auto entry = [&](int row, int column) {
    return j(row, 0) * vv * j(column, 0) + j(row, 1) * rr * j(column, 1);
  };
  // The slip in v_y may be wrong by all of itself: its formula knows neither how a turn begins and
  // ends nor the limit of grip.
  const double slip = v.v_y - car.rear_axle * v.yaw_rate;
  return {entry(0, 0) * inflation + floor_speed * floor_speed,
          entry(0, 1),
          entry(0, 2),
          entry(1, 1) * inflation + slip * slip + floor_speed * floor_speed,
          entry(1, 2),
          entry(2, 2) * inflation + floor_yaw_rate * floor_yaw_rate};
}

}  // namespace

void InertialMotion::advance(const HeldSignals& held, const AxleSpeed& speed,
                             Pose2& odom) noexcept {
  velocity_ = inertial_velocity(car_, speed.v_x, held.value(Source::yaw_rate));
  covariance_ = covariance_of(car_, velocity_, speed.sigma, held.sigma(Source::yaw_rate));
  if (moving_) {
    odom = moved(odom, velocity_, dt_);
  }
  moving_ = true;
}

void InertialMotion::resume(const BodyVelocity& velocity, const Symmetric3& covariance) noexcept {
  velocity_ = velocity;
  covariance_ = covariance;
  moving_ = true;
}

BodyVelocity InertialMotion::acceleration(const HeldSignals& held) const noexcept {
  if (!held.seen(Source::accel_x)) {
    return {};
  }
  // v̇_x = a_x + v_y ψ̇                                        (errata, 4)
  const double v_x_dot = held.value(Source::accel_x) + velocity_.v_y * velocity_.yaw_rate;
  // v̇_y = ∂v_y/∂v_x v̇_x
  const double v_y_dot =
      inertial_velocity_jacobian(car_, velocity_.v_x, velocity_.yaw_rate)(1, 0) * v_x_dot;
  return {v_x_dot, v_y_dot, 0.0};
}

template class TickFilter<InertialMotion>;

}  // namespace odomd::estimator
