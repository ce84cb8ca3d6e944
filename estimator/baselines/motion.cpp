#include "estimator/baselines/motion.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "estimator/common/symmetric3.hpp"

namespace odomd::estimator {

namespace {

// These keep the covariance positive definite: the Jacobian has rank two, or less at standstill.
constexpr double floor_rate = 1e-3;  // [m/s, rad/s]
constexpr double inflation = 1.0 + 1e-6;

/// J diag(σ²) Jᵀ with the σ of v_x and of the steering or gyro; the slip adds to the error of v_y.
Symmetric3 covariance_of(const DeadReckoning& model, double sigma_speed, double sigma_turn) {
  const Eigen::Vector2d sigma(sigma_speed, sigma_turn);
  const Eigen::Vector3d least(floor_rate, std::hypot(floor_rate, model.slip), floor_rate);
  Eigen::Matrix3d V = model.jacobian * sigma.cwiseAbs2().asDiagonal() * model.jacobian.transpose();
  V.diagonal() = inflation * V.diagonal() + least.cwiseAbs2();
  return packed(V);
}

/// Below this v_x [m/s] the discrete model is nearly unstable.
constexpr double slowest_v_x = -0.05;

/// A B, summed from left to right, so that vectorisation does not change the bits.
Eigen::Matrix3d product(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) noexcept {
  return a.col(0) * b.row(0) + a.col(1) * b.row(1) + a.col(2) * b.row(2);
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
    // Steering and yaw rate are assumed constant: the difference of two gyro samples is noise.
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
  // In a steady turn F_sh is (l_v / l) m v_x ψ̇, so the rear axle moves sideways at |v_x| α_h with
  // α_h = F_sh / C_h                                    (eqs 5, 7 and 27; errata, 5)
  const double gradient = car.front_axle * car.mass / (l * car.cornering_stiffness_rear);
  const double slip = v_x * speed * yaw_rate * gradient;

  DeadReckoning now;
  // v_y = l_h ψ̇                                              (errata, 7)
  const double lever = model == Model::kinematic_printed ? 0.0 : car.rear_axle;
  now.velocity = {v_x, lever * yaw_rate, yaw_rate};
  now.jacobian << 1.0, 0.0, lever * by, by;
  // The kinematic models neglect the slip. The inertial model's slip may be wrong by 100 %: the
  // formula holds neither in transients nor at the limit of grip.
  now.slip = slip;
  if (model == Model::inertial) {
    now.velocity.v_y -= slip;
    // ∂(v_x |v_x|)/∂v_x = 2 |v_x|
    now.jacobian.row(1) -= gradient * Eigen::RowVector2d(2.0 * speed * yaw_rate, v_x * speed);
  }
  return now;
}

void step_paper_ekf(const FilterSettings& settings, const Eigen::Vector2d& u,
                    const Eigen::Vector2d& z, Motion& motion) noexcept {
  const auto& [Q, R] = settings.paper;
  // x' = f(x, u) + w, z = h(x) + v: u = [δ, a_x], z = h = [ψ̇, v_x]   (eqs 13, 14 and 34 to 36)
  // x̂⁻ = f(x̂⁺, u),  Φ = ∂f/∂x at x̂⁺          (eqs 17, state_prediction, and 15)
  auto [x, phi] = paper_step(settings.vehicle, motion.velocity, u[0], u[1], settings.period_s);
  // P⁻ = Φ P Φᵀ + Q                             (eq. 18, covariance_prediction)
  Eigen::Matrix3d P = product(product(phi, unpacked(motion.covariance)), phi.transpose());
  P.diagonal() += Eigen::Vector3d(Q[0], Q[1], Q[2]);
  // P⁻ Hᵀ with H = ∂h/∂x = [0 0 1; 1 0 0] (eq. 16),  S = H P⁻ Hᵀ + R
  Eigen::Matrix<double, 3, 2> PHt;
  PHt << P.col(2), P.col(0);
  const Eigen::Matrix2d S{{P(2, 2) + R[0], P(0, 2)}, {P(0, 2), P(0, 0) + R[1]}};
  // K = P⁻ Hᵀ S⁻¹                               (eq. 19, kalman_gain)
  const Eigen::Matrix<double, 3, 2> K = PHt * S.inverse();
  // x̂⁺ = x̂⁻ + K (z - h(x̂⁻))                     (eq. 20, state_update)
  const Eigen::Vector3d correction = K * (z - Eigen::Vector2d(x.yaw_rate, x.v_x));
  motion.velocity = {x.v_x + correction[0], x.v_y + correction[1], x.yaw_rate + correction[2]};
  // P⁺ = (I - K H) P⁻                           (eq. 21, covariance_update)
  P = P - K.col(0) * PHt.col(0).transpose() - K.col(1) * PHt.col(1).transpose();
  motion.covariance = packed(P);
}

void advance_paper(const FilterSettings& settings, const HeldSignals& held, const AxleSpeed& speed,
                   Motion& motion) noexcept {
  if (motion.stopped) {
    return;
  }
  const double steering = held[Source::steering].value;
  const double accel_x = held[Source::accel_x].value;
  const double dt = settings.period_s;
  step_paper_ekf(settings, {steering, accel_x}, {held[Source::yaw_rate].value, speed.v_x}, motion);
  motion.stopped = motion.velocity.v_x < slowest_v_x;
  if (motion.stopped) {
    motion.velocity = {};
  }
  // X, Y and ψ with one forward Euler step, which uses the heading before it (eqs 28 to 30)
  const auto& [v_x, v_y, yaw_rate] = motion.mean = motion.velocity;
  motion.way = {dt * v_x, dt * v_y, dt * yaw_rate};
  motion.rate = motion.stopped ? BodyVelocity{}
                               : dynamic_rate(settings.vehicle, motion.velocity, steering, accel_x,
                                              slowest_resolved_speed(settings.vehicle, dt));
}

BodyVelocity dynamic_rate(const Vehicle& car, const BodyVelocity& v, double steering,
                          double accel_x, double speed_floor) noexcept {
  const auto& [v_x, v_y, yaw_rate] = v;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  const double speed = std::max(std::abs(v_x), speed_floor);
  // α_v = δ - β - ψ̇ l_v / v, with β = v_y / v: α_v = (v_x δ - (v_y + l_v ψ̇)) / |v_x|
  //                                                (eq. 6, alpha_v_alternative; errata, 5)
  const double alpha_v = (v_x * steering - (v_y + l_v * yaw_rate)) / speed;
  // α_h = -β + ψ̇ l_h / v = -(v_y - l_h ψ̇) / |v_x|         (eq. 7; errata, 5)
  const double alpha_h = -(v_y - l_h * yaw_rate) / speed;
  // F_sv = C_v α_v,  F_sh = C_h α_h                          (eqs 4 and 5, Fsh)
  const double f_sv_lateral = car.cornering_stiffness_front * alpha_v * std::cos(steering);
  const double f_sh = car.cornering_stiffness_rear * alpha_h;
  return {
      // v̇_x = a_x + v_y ψ̇: the accelerometer includes F_sv sin δ / m (eq. 10; errata, 4)
      accel_x + v_y * yaw_rate,
      // v̇_y = -v_x ψ̇ + (F_sv cos δ + F_sh) / m              (eq. 11)
      -v_x * yaw_rate + (f_sv_lateral + f_sh) / car.mass,
      // ψ̈ = (l_v F_sv cos δ - l_h F_sh) / J_z                (eq. 12, psidot_dot)
      (l_v * f_sv_lateral - l_h * f_sh) / car.yaw_inertia,
  };
}

PaperStep paper_step(const Vehicle& car, const BodyVelocity& v, double steering, double accel_x,
                     double dt) noexcept {
  const auto& [v_x, v_y, yaw_rate] = v;
  const double m = car.mass;
  const double j_z = car.yaw_inertia;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  const double c_v = car.cornering_stiffness_front;
  const double c_h = car.cornering_stiffness_rear;
  const double coupling = dt * (l_v * c_v - l_h * c_h);
  const double steer = dt * c_v * steering;

  // v_y,k = (a - b) / (m v_x + Δt (C_v + C_h))               (eq. 32, discrete_vy; errata, 2)
  // a = m v_x v_y - Δt (l_v C_v - l_h C_h) ψ̇                 (a; errata, 2)
  // b = -Δt C_v δ v_x + Δt m v_x² ψ̇                          (b; errata, 1 and 2)
  const double per_vy = 1.0 / (m * v_x + dt * (c_v + c_h));
  const double v_y_next =
      (m * v_x * v_y - coupling * yaw_rate + steer * v_x - dt * m * v_x * v_x * yaw_rate) * per_vy;
  // ψ̇_k = (c - d) / (J_z v_x + Δt (l_v² C_v + l_h² C_h))     (eq. 33, discrete_psidot; errata, 2)
  // c = J_z v_x ψ̇ - Δt (l_v C_v - l_h C_h) v_y               (c; errata, 2)
  // d = -Δt l_v C_v δ v_x                                    (d; errata, 2)
  const double per_yaw = 1.0 / (j_z * v_x + dt * (l_v * l_v * c_v + l_h * l_h * c_h));
  const double yaw_rate_next =
      (j_z * v_x * yaw_rate - coupling * v_y + l_v * steer * v_x) * per_yaw;

  PaperStep step;
  // v_x,k = v_x + Δt a_x                                     (eq. 31, discrete_vx)
  step.velocity = {v_x + dt * accel_x, v_y_next, yaw_rate_next};
  // ∂(N/D)/∂v_x = (∂N/∂v_x - (N/D) ∂D/∂v_x) / D; D does not depend on v_y and ψ̇.
  step.phi.row(0) << 1.0, 0.0, 0.0;
  step.phi.row(1) << (m * (v_y - v_y_next) + steer - dt * m * yaw_rate * (2.0 * v_x)) * per_vy,
      m * v_x * per_vy, -(coupling + dt * m * v_x * v_x) * per_vy;
  step.phi.row(2) << (j_z * (yaw_rate - yaw_rate_next) + l_v * steer) * per_yaw,
      -coupling * per_yaw, j_z * v_x * per_yaw;
  return step;
}

}  // namespace odomd::estimator
