// docs/model.md, "Process".
#include "estimator/ekf/process_model.hpp"

#include <algorithm>
#include <memory>

#include "estimator/common/symmetric3.hpp"
#include "estimator/ekf/plausibility.hpp"

namespace odomd::estimator::full {
namespace {

/// 1/μ of an axle [s²/m]; `grip`: as configured, 0: none.
double softness_of(double grip, const Moving& now) noexcept {
  constexpr double most = 2.0;
  return std::clamp(usual_softness(grip) + now.softness, 0.0, most);
}

/// Random walk of the gyro's bias: faster for a noisy gyro.
double gyro_bias_walk(const CarModel& model, const State& state) noexcept {
  const NoiseLevel& level = state.noise[index_of(Source::yaw_rate)];
  // A running engine may shake the gyro beyond its noise.
  const double noise =
      level.still.samples > 1 ? model.gyro_sigma * std::sqrt(std::min(level.still.mean, 1.0)) : 0.0;
  return std::max(model.tuning.gyro_bias_walk, model.tuning.gyro_bias_walk_share * noise);
}

/// Adds the process noise of the random walks, and decays `disputed`.
void add_walks(const CarModel& model, double dt, State& state) noexcept {
  const Tuning& tuning = model.tuning;
  state.disputed *= std::max(1.0 - 0.5 * dt / tuning.disputed_s, 0.0);
  for (const at::Index bias : {at::accel_bias_x, at::accel_bias_y}) {
    state.variance(bias) += squared(tuning.accel_bias_walk) * dt;
  }
  state.variance(at::steering_offset) += squared(tuning.steering_offset_walk) * dt;
  for (const slow::Index error :
       {slow::gyro_bias, slow::gyro_scale, slow::wheel_scale, slow::stiffness_scale}) {
    const double walk = tuning.*slow_priors.begin()[error].walk;
    state.variance(error) +=
        squared(error == slow::gyro_bias ? gyro_bias_walk(model, state) : walk) * dt;
  }
}

/// F of a step: identity except for its first nine rows, x ... side_force.
struct Jacobian {
  VelocityStep velocity;
  double steered = 0.0;  ///< 1: there is a steering signal, so δ_0 counts
  double dt = 0.0;
  double half = 0.0;  ///< Δt / 2
  double dx = 0.0;    ///< displacement of the step
  double dy = 0.0;
  double half_c = 1.0;  ///< Δt / 2 cos ψ_m, Δt / 2 sin ψ_m
  double half_s = 0.0;
  double driving_decay = 1.0;
  double force_decay = 1.0;
};

/// a ← F a for elements `stride` apart, from row `first` on: x, v_x or accel_x.
template <Eigen::Index stride>
[[gnu::always_inline]] inline void apply(const Jacobian& F, at::Index first, double* a) noexcept {
  const auto of = [a](at::Index i) -> double& { return a[i * stride]; };
  if (first <= at::v_x) {
    const auto& by = F.velocity.by;
    const auto& by_front = F.velocity.by_front_wheel;
    const double v_x = of(at::v_x);
    const double v_y = of(at::v_y);
    const double turn = of(at::yaw_rate);
    const double front = of(at::front_angle) - F.steered * of(at::steering_offset);
    of(at::v_x) += by(0, 1) * v_y + by(0, 2) * turn + F.dt * of(at::accel_x);
    of(at::v_y) = by(1, 0) * v_x + by(1, 1) * v_y + by(1, 2) * turn + by_front[0] * front +
                  F.velocity.by_side_force * of(at::side_force);
    of(at::yaw_rate) = by(2, 0) * v_x + by(2, 1) * v_y + by(2, 2) * turn + by_front[1] * front;
    if (first == at::x) {
      // Derivatives with respect to ½ (v + v') and to the yaw: ∂X'/∂ψ_m = -ΔY, ∂Y'/∂ψ_m = ΔX
      const double along = v_x + of(at::v_x);
      const double across = v_y + of(at::v_y);
      const double turned = F.half * (turn + of(at::yaw_rate));
      const double middle = of(at::yaw) + 0.5 * turned;
      of(at::x) += F.half_c * along - F.half_s * across - F.dy * middle;
      of(at::y) += F.half_s * along + F.half_c * across + F.dx * middle;
      of(at::yaw) += turned;
    }
  }
  of(at::accel_x) *= F.driving_decay;
  of(at::front_angle) *= F.driving_decay;
  of(at::side_force) *= F.force_decay;
}

/// Adds to B the effect of a slow error of tyres or steering on velocity and pose in the step.
void add_turn(const Jacobian& F, const Eigen::Vector2d& by_error, slow::Index error,
              State& state) noexcept {
  auto by = state.slow.sensitivity.col(error);
  const double across = by_error[0];
  const double turn = by_error[1];
  const double middle = 0.5 * F.half * turn;
  by[at::x] -= F.half_s * across + F.dy * middle;
  by[at::y] += F.half_c * across + F.dx * middle;
  by[at::yaw] += F.half * turn;
  by[at::v_y] += across;
  by[at::yaw_rate] += turn;
}

/// Steps the mean, and returns F.
Jacobian step_mean(const CarModel& model, const Input& input, double dt, State& state) noexcept {
  const Tuning& tuning = model.tuning;
  Vector& x = state.mean;
  Jacobian F{.velocity = velocity_step(model.car, moving(state, input), dt),
             .steered = input.has_steering ? 1.0 : 0.0,
             .dt = dt,
             .half = 0.5 * dt};

  // X' = X + Δt (v̄_x cos ψ_m - v̄_y sin ψ_m),  Y' = Y + Δt (v̄_x sin ψ_m + v̄_y cos ψ_m),
  // ψ' = ψ + Δt ψ̇_m,  ψ_m = ψ + Δt ψ̇_m / 2                                       (eqs 8 and 9)
  const Eigen::Vector3d mean = 0.5 * (x.segment<3>(at::v_x) + F.velocity.velocity);
  const double middle = x[at::yaw] + 0.5 * dt * mean[2];
  F.half_c = F.half * std::cos(middle);
  F.half_s = F.half * std::sin(middle);
  F.dx = 2.0 * (mean[0] * F.half_c - mean[1] * F.half_s);
  F.dy = 2.0 * (mean[0] * F.half_s + mean[1] * F.half_c);
  x[at::x] += F.dx;
  x[at::y] += F.dy;
  x[at::yaw] += dt * mean[2];
  state.turned += dt * mean[2];
  x.segment<3>(at::v_x) = F.velocity.velocity;
  F.driving_decay = tuning.driving_s / (tuning.driving_s + dt);
  x[at::accel_x] *= F.driving_decay;
  x[at::front_angle] *= F.driving_decay;
  F.force_decay = tuning.side_force_s / (tuning.side_force_s + dt);
  x[at::side_force] *= F.force_decay;
  return F;
}

void add_noise(const CarModel& model, const Jacobian& F, State& state) noexcept {
  const Tuning& tuning = model.tuning;
  const Vector& x = state.mean;
  const double speed = std::abs(x[at::v_x]);
  const double wheelbase = model.car.wheelbase();
  const double on_road = squared(gravity) * speed * F.dt;
  state.variance(at::accel_bias_x) += squared(tuning.slope) * on_road;
  state.variance(at::accel_bias_y) += squared(tuning.bank) * on_road;
  const double way = state.way_noise_scale * squared(tuning.way) * wheelbase * speed * F.dt;
  state.variance(at::x) += way;
  state.variance(at::y) += way;
  state.variance(at::yaw) += squared(tuning.way_turn) * speed / wheelbase * F.dt;
  const double bend = x[at::v_x] * x[at::yaw_rate] / gravity;  // [g]
  // The more uncertain the grip, the closer the model error is to that of an unknown tyre.
  const double unknown =
      model.car.grip_rear > 0.0
          ? 0.0
          : std::min(state.variance(slow::softness) / squared(tuning.softness), 1.0);
  const double known = squared(tuning.side_slip_grip);
  const double share = std::sqrt(known + (1.0 - known) * unknown);
  const double side = share * tuning.side_slip * gravity * bend * bend * bend;
  // If v_x is known, the accelerometer determines v_y whatever the tyres do: v̇_y = a_y - v_x ψ̇.
  // Then e with the variance q / 2T models a white error of v̇_y with the density q.
  const bool known_speed = knows_speed(model.car.driven, state);
  state.variance(at::v_y) +=
      ((known_speed ? 0.0 : squared(side)) + squared(tuning.side_slip_floor * gravity)) * F.dt;
  const double relative =
      std::hypot(tuning.side_force, known_speed ? rear_spin(model.car, state) : 0.0);
  state.variance(at::side_force) +=
      (squared(relative * x[at::v_x] * x[at::yaw_rate]) +
       (known_speed ? squared(side) / (2.0 * tuning.side_force_s) : 0.0) +
       squared(tuning.side_force_floor * gravity)) *
      (1.0 - squared(F.force_decay));
  state.variance(at::yaw_rate) += squared(tuning.turn * model.gyro_sigma) * F.dt;
  state.variance(at::accel_x) += state.drive_noise_scale * squared(tuning.drive_accel * gravity) *
                                 (1.0 - squared(F.driving_decay));
  state.variance(at::front_angle) +=
      state.turn_noise_scale * squared(tuning.front_angle) * (1.0 - squared(F.driving_decay));
  add_walks(model, F.dt, state);
}

}  // namespace

Secant secant_stiffness(double stiffness, double slip_angle, double softness,
                        double share_of_mass) noexcept {
  const double linear = stiffness * std::abs(slip_angle) / share_of_mass;
  const double q = third * linear * softness;
  return q < 1.0
             ? Secant{stiffness * (1.0 - q + third * q * q),
                      third * stiffness * linear * (2.0 * third * q - 1.0)}
             : Secant{stiffness / (linear * softness), -stiffness / (linear * softness * softness)};
}

VelocityStep velocity_step(const Vehicle& car, const Moving& now, double dt) noexcept {
  const double m = car.mass;
  const double j_z = car.yaw_inertia;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  const double v_x = now.v_x;
  const double v_y = now.v_y;
  const double r = now.yaw_rate;
  const double delta = now.front_wheel;
  const double k = now.stiffness;
  const double w = std::abs(v_x);
  // dw/dv_x; the mean of both sides at v_x = 0, where |v_x| has a kink.
  const double sign = (v_x > 0.0 ? 1.0 : 0.0) - (v_x < 0.0 ? 1.0 : 0.0);

  // Secant stiffnesses at the slip angles α of the axles (eqs 6 and 7)
  Secant front{car.cornering_stiffness_front};
  Secant rear{car.cornering_stiffness_rear};
  double front_by_w = 0.0;
  double rear_by_w = 0.0;
  if (w > 0.0) {
    const double l = car.wheelbase();
    // A tyre with |v_along| + |v_across| below a wheelbase per second does not slide.
    const auto at_slip = [&](Secant& axle, double& by_w, double across, double grip, double share) {
      const double softness = softness_of(grip, now);
      const double least = l - std::abs(across);
      axle = secant_stiffness(axle.stiffness, across / std::max(w, least), softness, m * share);
      // If the tyre slides sideways and rolls below a wheelbase per second, C depends on |v_x|.
      by_w = w > least && w < l ? -axle.by_softness * softness / w : 0.0;
    };
    at_slip(front, front_by_w, v_x * delta - v_y - l_v * r, car.grip_front, l_h / l);
    at_slip(rear, rear_by_w, l_h * r - v_y, car.grip_rear, l_v / l);
  }
  const double c_v = front.stiffness;
  const double c_h = rear.stiffness;
  // Terms that the stiffness multiplies, per unit of k
  const double coupling = dt * (l_v * c_v - l_h * c_h);
  const double steer_by_delta = dt * c_v * v_x;
  const double steer = steer_by_delta * delta;
  const double damping_y = dt * (c_v + c_h);
  const double damping_yaw = dt * (l_v * l_v * c_v + l_h * l_h * c_h);

  // v_y,k = N_y / D_y and ψ̇_k = N_ψ / D_ψ                                  (eqs 32 and 33)
  const double per_y = 1.0 / (m * w + k * damping_y);
  const double per_yaw = 1.0 / (j_z * w + k * damping_yaw);
  const double v_y_next =
      (m * w * v_y + k * (steer - coupling * r) - dt * m * w * (v_x * r - now.side_force)) * per_y;
  const double r_next = (j_z * w * r + k * (l_v * steer - coupling * v_y)) * per_yaw;

  VelocityStep step;
  step.velocity << v_x + dt * (now.accel_x + v_y * r), v_y_next, r_next;
  // ∂(N/D) = (∂N - (N/D) ∂D) / D, with the secant stiffnesses held constant
  step.by << 1.0, dt * r, dt * v_y,  //
      (m * sign * (v_y - v_y_next + dt * now.side_force) + k * dt * c_v * delta -
       dt * m * r * (w + v_x * sign)) *
          per_y,
      m * w * per_y, -(k * coupling + dt * m * v_x * w) * per_y,  //
      (j_z * sign * (r - r_next) + k * l_v * dt * c_v * delta) * per_yaw, -k * coupling * per_yaw,
      j_z * w * per_yaw;
  step.by_side_force = dt * m * w * per_y;
  step.by_front_wheel << k * steer_by_delta * per_y, k * l_v * steer_by_delta * per_yaw;
  step.by_stiffness << (steer - coupling * r - v_y_next * damping_y) * per_y,
      (l_v * steer - coupling * v_y - r_next * damping_yaw) * per_yaw;
  const auto by_tyres = [&](double by_front, double by_rear) -> Eigen::Vector2d {
    return k * dt *
           Eigen::Vector2d{
               (by_front * (v_x * delta - l_v * r - v_y_next) + by_rear * (l_h * r - v_y_next)) *
                   per_y,
               (by_front * l_v * (v_x * delta - v_y - l_v * r_next) +
                by_rear * l_h * (v_y - l_h * r_next)) *
                   per_yaw};
  };
  step.by_softness = by_tyres(front.by_softness, rear.by_softness);
  step.by.block<2, 1>(1, 0) += sign * by_tyres(front_by_w, rear_by_w);
  return step;
}

// Inlined, so that the derivatives are not computed.
[[gnu::flatten]] Eigen::Vector3d velocity_after(const CarModel& model, Moving now, double time_s,
                                                long steps) noexcept {
  const double dt = time_s / static_cast<double>(steps);
  const double driving_decay = model.tuning.driving_s / (model.tuning.driving_s + dt);
  for (long done = 0; done < steps; ++done) {
    const Eigen::Vector3d next = velocity_step(model.car, now, dt).velocity;
    now.v_x = next[0];
    now.v_y = next[1];
    now.yaw_rate = next[2];
    now.accel_x *= driving_decay;
  }
  return {now.v_x, now.v_y, now.yaw_rate};
}

Moving moving(const State& state, const Input& input) noexcept {
  const Vector& x = state.mean;
  const double known = input.has_steering ? input.steering - x[at::steering_offset] : 0.0;
  return {x[at::v_x],
          x[at::v_y],
          x[at::yaw_rate],
          x[at::accel_x],
          known + x[at::front_angle],
          x[at::side_force],
          1.0 + state.slow.mean[slow::stiffness_scale],
          state.slow.mean[slow::softness]};
}

void propagate(const CarModel& model, const Input& input, double dt, State& state) noexcept {
  const Jacobian F = step_mean(model, input, dt, state);
  // P ← F P Fᵀ + Q: first P Fᵀ with all rows at once, then the lower half of F (P Fᵀ).
  double* const P = std::assume_aligned<16>(state.covariance.data());
  for (Eigen::Index row = 0; row < at::size; ++row) {
    apply<at::size>(F, at::x, P + row);
  }
  for (const at::Index first : {at::x, at::v_x, at::accel_x}) {
    for (Eigen::Index column = first; column < first + at::v_x; ++column) {
      apply<1>(F, first, P + column * at::size);
    }
  }
  for (Eigen::Index row = 1; row < at::size; ++row) {
    state.covariance.col(row).head(row) = state.covariance.row(row).head(row).transpose();
  }
  // B ← F B + ∂f/∂s
  const SlowVector yaw_by = state.slow.sensitivity.row(at::yaw);
  double* const B = state.slow.sensitivity.data();
  for (Eigen::Index column = 0; column < slow::size; ++column) {
    apply<slow::size>(F, at::x, B + column);
  }
  add_turn(F, F.velocity.by_stiffness, slow::stiffness_scale, state);
  add_turn(F, F.velocity.by_softness, slow::softness, state);
  if (input.has_steering) {
    // the signal lags δ by τ_δ: ∂δ/∂τ_δ = δ̇
    add_turn(F, F.velocity.by_front_wheel * (input.change / dt), slow::steering_latency, state);
  }
  state.turned_by += state.slow.sensitivity.row(at::yaw).transpose() - yaw_by;
  add_noise(model, F, state);
}

void propagate_standing(const CarModel& model, double dt, State& state) noexcept {
  add_walks(model, dt, state);
}

}  // namespace odomd::estimator::full
