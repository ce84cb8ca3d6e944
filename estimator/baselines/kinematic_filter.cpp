#include "estimator/baselines/kinematic_filter.hpp"

#include <cmath>

#include "estimator/baselines/tick_filter_impl.hpp"

namespace odomd::estimator {
namespace {

// Keep the covariance positive definite: the Jacobian has rank two, and less at standstill.
constexpr double floor_speed = 1e-3;     // [m/s]
constexpr double floor_yaw_rate = 1e-3;  // [rad/s]
constexpr double inflation = 1.0 + 1e-6;

Symmetric3 covariance_of(const Vehicle& car, KinematicForm form, const Eigen::Vector2d& input,
                         const BodyVelocity& v, double sigma_speed, double sigma_steering) {
  // J diag(σ_v², σ_δ²) Jᵀ, with J = ∂(v_x, v_y, ψ̇) / ∂(v_x, δ)
  const Eigen::Matrix<double, 3, 2> j = kinematic_velocity_jacobian(car, form, input);
  const double vv = sigma_speed * sigma_speed;
  const double dd = sigma_steering * sigma_steering;
  const auto entry = [&](int row, int column) {
    return j(row, 0) * vv * j(column, 0) + j(row, 1) * dd * j(column, 1);
  };
  // The neglected slip of the rear axle: α_h = F_sh / C_h with F_sh = (l_v / l) m a_y and
  // a_y = v_x ψ̇ (eq. 27, cornering_stiffness_rear) makes v_y err by v_x α_h.
  const double alpha_h = car.front_axle / car.wheelbase() * car.mass * v.v_x * v.yaw_rate /
                         car.cornering_stiffness_rear;
  const double slip = v.v_x * alpha_h;
  return {entry(0, 0) * inflation + floor_speed * floor_speed,
          entry(0, 1),
          entry(0, 2),
          entry(1, 1) * inflation + slip * slip + floor_speed * floor_speed,
          entry(1, 2),
          entry(2, 2) * inflation + floor_yaw_rate * floor_yaw_rate};
}

}  // namespace

void KinematicMotion::advance(const HeldSignals& held, const AxleSpeed& speed,
                              Pose2& odom) noexcept {
  const Eigen::Vector2d input{speed.v_x, held.value(Source::steering)};
  const Eigen::Vector3d next = kinematic_velocity<double>(car_, form_, input);
  const BodyVelocity before = velocity_;
  velocity_ = {next[0], next[1], next[2]};
  covariance_ =
      covariance_of(car_, form_, input, velocity_, speed.sigma, held.sigma(Source::steering));
  if (moving_) {
    const BodyVelocity mean{(before.v_x + velocity_.v_x) / 2.0, (before.v_y + velocity_.v_y) / 2.0,
                            (before.yaw_rate + velocity_.yaw_rate) / 2.0};
    odom = moved(odom, mean, dt_);
  }
  moving_ = true;
}

void KinematicMotion::resume(const BodyVelocity& velocity, const Symmetric3& covariance) noexcept {
  velocity_ = velocity;
  covariance_ = covariance;
  moving_ = true;
}

BodyVelocity KinematicMotion::acceleration(const HeldSignals& held) const noexcept {
  if (!held.seen(Source::accel_x)) {
    return {};
  }
  // v̇_x = a_x + v_y ψ̇                                        (errata, 4)
  const double v_x_dot = held.value(Source::accel_x) + velocity_.v_y * velocity_.yaw_rate;
  // The model's velocity is linear in v_x; the steering is held.
  const Eigen::Vector3d rate =
      kinematic_velocity<double>(car_, form_, {v_x_dot, held.value(Source::steering)});
  return {rate[0], rate[1], rate[2]};
}

template class TickFilter<KinematicMotion>;

}  // namespace odomd::estimator
