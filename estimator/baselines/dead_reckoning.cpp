// The kinematic bicycle and the slip odometer: velocities by the newest signals alone.
#include <cmath>

#include "estimator/baselines/motion.hpp"
#include "estimator/common/squares.hpp"

namespace odomd::estimator {
namespace {

// Keep the covariance positive definite: the Jacobian has rank two, or less at standstill.
constexpr double floor_speed = 1e-3;     // [m/s]
constexpr double floor_yaw_rate = 1e-3;  // [rad/s]
constexpr double inflation = 1.0 + 1e-6;

/// J diag(σ²) Jᵀ, with the σ of v_x and of steering or gyro; v_y also errs by the slip.
Symmetric3 covariance_of(const DeadReckoning& model, double sigma_speed, double sigma_turn) {
  const Eigen::Vector2d sigma(sigma_speed, sigma_turn);
  const Eigen::Vector3d least(floor_speed, std::hypot(floor_speed, model.slip), floor_yaw_rate);
  Eigen::Matrix3d V = model.jacobian * sigma.cwiseAbs2().asDiagonal() * model.jacobian.transpose();
  V.diagonal() = inflation * V.diagonal() + least.cwiseAbs2();
  return packed(V);
}

}  // namespace

void advance_dead_reckoning(Model model, const FilterSettings& settings, const HeldSignals& held,
                            const GyroBias& bias, const AxleSpeed& speed, Motion& motion) noexcept {
  const HeldSignal& held_turn = held[uses_gyro(model) ? Source::yaw_rate : Source::steering];
  const double turn = held_turn.value - (uses_gyro(model) ? bias.value() : 0.0);
  const DeadReckoning now = reckon(model, settings.vehicle, speed.v_x, turn);
  const BodyVelocity& v = now.velocity;
  const BodyVelocity& before = uses_gyro(model) || !motion.moving ? v : motion.velocity;
  motion.mean = {(before.v_x + v.v_x) / 2.0, (before.v_y + v.v_y) / 2.0,
                 (before.yaw_rate + v.yaw_rate) / 2.0};
  motion.way = motion.moving ? moved({}, motion.mean, settings.period_s) : Pose2{};
  motion.velocity = v;
  motion.covariance = covariance_of(now, speed.sigma, held_turn.sigma);
  if (uses_gyro(model)) {
    const Eigen::Vector3d by_turn = now.jacobian.col(1);
    motion.sensitivity << by_turn, turn * by_turn, speed.v_x * now.jacobian.col(0);
    motion.error_variance << bias.variance(), squared(settings.tuning.gyro_scale),
        squared(settings.tuning.wheel_scale);
  }
  motion.moving = true;

  motion.rate = {};
  if (held[Source::accel_x].seen) {
    // v̇_x = a_x + v_y ψ̇                                        (errata, 4)
    const double v_x_dot = held[Source::accel_x].value + v.v_y * v.yaw_rate;
    // Steering and yaw rate count as constant: the difference of two gyro samples is noise.
    motion.rate = {v_x_dot, now.jacobian(1, 0) * v_x_dot, now.jacobian(2, 0) * v_x_dot};
  }
}

DeadReckoning reckon(Model model, const Vehicle& car, double v_x, double turn) noexcept {
  const double l = car.wheelbase();
  const double speed = std::abs(v_x);
  double yaw_rate = turn;
  Eigen::RowVector2d by(0.0, 1.0);  // ∂ψ̇ / ∂(v_x, turn)
  if (!uses_gyro(model)) {
    // ψ̇ = v_x / (l_v + l_h) tan δ                            (eq. 1)
    const double tangent = std::tan(turn);
    yaw_rate = v_x / l * tangent;
    by << tangent / l, v_x * (1.0 + tangent * tangent) / l;
  }
  // In a steady turn α_h = F_sh / C_h with F_sh = (l_v / l) m v_x ψ̇ makes the rear axle slip by
  // |v_x| α_h                                                (eqs 5, 7 and 27; errata, 5)
  const double gradient = car.front_axle * car.mass / (l * car.cornering_stiffness_rear);
  const double slip = v_x * speed * yaw_rate * gradient;

  DeadReckoning now;
  // v_y = l_h ψ̇                                              (errata, 7)
  const double lever = model == Model::kinematic_printed ? 0.0 : car.rear_axle;
  now.velocity = {v_x, lever * yaw_rate, yaw_rate};
  now.jacobian << 1.0, 0.0, lever * by, by;
  // The kinematic models neglect the slip. That of the inertial one may be wrong by all of itself:
  // the formula holds neither in transients nor at the limit of grip.
  now.slip = slip;
  if (model == Model::inertial) {
    now.velocity.v_y -= slip;
    // ∂(v_x |v_x|)/∂v_x = 2 |v_x|
    now.jacobian.row(1) -= gradient * Eigen::RowVector2d(2.0 * speed * yaw_rate, v_x * speed);
  }
  return now;
}

}  // namespace odomd::estimator
