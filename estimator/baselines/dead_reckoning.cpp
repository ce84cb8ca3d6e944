// The kinematic bicycle and the slip odometer: velocities from the newest signals alone.
#include <cmath>

#include "estimator/baselines/motion.hpp"

namespace odomd::estimator {
namespace {

// Keep the covariance positive definite: the Jacobian has rank two, and less at standstill.
constexpr double floor_speed = 1e-3;     // [m/s]
constexpr double floor_yaw_rate = 1e-3;  // [rad/s]
constexpr double inflation = 1.0 + 1e-6;

/// J diag(σ²) Jᵀ, with the standard deviations of v_x and of δ or ψ̇; and v_y errs by the slip.
Symmetric3 covariance_of(const DeadReckoning& model, double sigma_speed, double sigma_turn) {
  const auto& j = model.jacobian;
  const double vv = sigma_speed * sigma_speed;
  const double rr = sigma_turn * sigma_turn;
  const auto entry = [&](int row, int column) {
    return j(row, 0) * vv * j(column, 0) + j(row, 1) * rr * j(column, 1);
  };
  return {entry(0, 0) * inflation + floor_speed * floor_speed,
          entry(0, 1),
          entry(0, 2),
          entry(1, 1) * inflation + model.slip * model.slip + floor_speed * floor_speed,
          entry(1, 2),
          entry(2, 2) * inflation + floor_yaw_rate * floor_yaw_rate};
}

BodyVelocity mean(const BodyVelocity& a, const BodyVelocity& b) noexcept {
  return {(a.v_x + b.v_x) / 2.0, (a.v_y + b.v_y) / 2.0, (a.yaw_rate + b.yaw_rate) / 2.0};
}

DeadReckoning reckon(Model model, const Vehicle& car, double v_x,
                     const HeldSignals& held) noexcept {
  if (model == Model::inertial) {
    return inertial(car, v_x, held[Source::yaw_rate].value);
  }
  const double lever = model == Model::kinematic_printed ? 0.0 : car.rear_axle;
  return kinematic(car, lever, v_x, held[Source::steering].value);
}

}  // namespace

void advance_dead_reckoning(Model model, const FilterSettings& settings, const HeldSignals& held,
                            const AxleSpeed& speed, Motion& motion) noexcept {
  const DeadReckoning now = reckon(model, settings.vehicle, speed.v_x, held);
  const bool gyro = uses_gyro(model);
  if (motion.moving) {
    const BodyVelocity velocity = gyro ? now.velocity : mean(motion.velocity, now.velocity);
    motion.odom = moved(motion.odom, velocity, settings.period_s);
  }
  motion.velocity = now.velocity;
  motion.covariance =
      covariance_of(now, speed.sigma, held[gyro ? Source::yaw_rate : Source::steering].sigma);
  motion.moving = true;
}

BodyVelocity dead_reckoning_acceleration(Model model, const FilterSettings& settings,
                                         const HeldSignals& held, const Motion& motion) noexcept {
  if (!held[Source::accel_x].seen) {
    return {};
  }
  const BodyVelocity& v = motion.velocity;
  // v̇_x = a_x + v_y ψ̇                                        (errata, 4)
  const double v_x_dot = held[Source::accel_x].value + v.v_y * v.yaw_rate;
  if (uses_gyro(model)) {
    // v̇_y = ∂v_y/∂v_x v̇_x; the yaw rate is held, for a gyro's differences are noise.
    const double by_v_x = inertial(settings.vehicle, v.v_x, v.yaw_rate).jacobian(1, 0);
    return {v_x_dot, by_v_x * v_x_dot, 0.0};
  }
  // The model's velocity is linear in v_x; the steering is held.
  return reckon(model, settings.vehicle, v_x_dot, held).velocity;
}

DeadReckoning kinematic(const Vehicle& car, double lever, double v_x, double steering) noexcept {
  DeadReckoning now;
  const double tangent = std::tan(steering);
  // ψ̇ = v_x / (l_v + l_h) tan δ                              (eq. 1)
  const double yaw_rate = v_x / car.wheelbase() * tangent;
  // v_y = l_h ψ̇                                              (errata, 7)
  now.velocity = {v_x, lever * yaw_rate, yaw_rate};
  // ∂ψ̇/∂v_x = tan δ / l,  ∂ψ̇/∂δ = v_x (1 + tan² δ) / l
  const double by_speed = tangent / car.wheelbase();
  const double by_steering = v_x * (1.0 + tangent * tangent) / car.wheelbase();
  now.jacobian << 1.0, 0.0, lever * by_speed, lever * by_steering, by_speed, by_steering;
  // The neglected slip of the rear axle: α_h = F_sh / C_h with F_sh = (l_v / l) m a_y and
  // a_y = v_x ψ̇ (eq. 27, cornering_stiffness_rear) makes v_y err by v_x α_h.
  const double alpha_h =
      car.front_axle / car.wheelbase() * car.mass * v_x * yaw_rate / car.cornering_stiffness_rear;
  now.slip = v_x * alpha_h;
  return now;
}

DeadReckoning inertial(const Vehicle& car, double v_x, double yaw_rate) noexcept {
  DeadReckoning now;
  // l_v m / (l C_h): what the slip angle of the rear axle grows by per lateral acceleration
  const double gradient =
      car.front_axle * car.mass / (car.wheelbase() * car.cornering_stiffness_rear);
  // v_y = l_h ψ̇ - v_x |v_x| ψ̇ l_v m / (l C_h)                (eqs 5, 7 and 27; errata, 5)
  const double slip = v_x * std::abs(v_x) * yaw_rate * gradient;
  now.velocity = {v_x, car.rear_axle * yaw_rate - slip, yaw_rate};
  // ∂(v_x |v_x|)/∂v_x = 2 |v_x|
  now.jacobian << 1.0, 0.0, -2.0 * std::abs(v_x) * yaw_rate * gradient,
      car.rear_axle - v_x * std::abs(v_x) * gradient, 0.0, 1.0;
  // The slip may be wrong by all of itself: its formula knows neither how a turn begins and ends
  // nor the limit of grip.
  now.slip = now.velocity.v_y - car.rear_axle * yaw_rate;
  return now;
}

}  // namespace odomd::estimator
