// Measurement models: predicted samples of the car's motion sensors, with their derivatives.
//
// docs/model.md, "Measurements".
#pragma once

#include "estimator/common/vehicle.hpp"
#include "estimator/ekf/process_model.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

/// The gyro: z = (1 + s_g) (ψ̇ - τ ψ̈) + b_g, τ = τ_g - `advanced_s`.
[[nodiscard]] Prediction predict_yaw_rate(const State& state, double sigma,
                                          double advanced_s = 0.0) noexcept;

/// A wheel's share of the force on the car, relative to that of a driven wheel under power. Under
/// braking all four wheels share the force, each with half the share of one of two driven wheels.
[[nodiscard]] constexpr double slip_share(Driven driven, Source source, double force) noexcept {
  if (force > 0.0) {
    return is_driven(driven, source) ? 1.0 : 0.0;
  }
  return driven == Driven::all ? 1.0 : 0.5;
}

/// z = (1 + s_w) (1 ± d_w / 2) (1 + c_s η a) (u cos δ + u_⊥ sin δ), a = ± (a_x + d), with u = v_x -
/// τ v̇_x - y_w ψ̇ and u_⊥ = v_y + x_w ψ̇ the velocity at the wheel's position (x_w, y_w); δ = 0
/// for a rear wheel. η is the wheel's slip_share(), ± the sign of v_x, d = (l_h / l) v_x ψ̇ sin δ
/// the drag of the front tyres in a turn.
///
/// A wheel corrects v_x. The difference between two wheels says little about ψ̇ (a radius error of
/// 0.3 % makes 0.03 rad/s at 1.5 m/s) and nothing about v_y: both count as known, and their
/// variance as noise. Without a gyro (`gyro` false) a wheel corrects ψ̇, too. Without steering in
/// `input` a front wheel rolls along the velocity of its axle's centre.
[[nodiscard]] Prediction predict_wheel_speed(const CarModel& model, const Input& input,
                                             const State& state, Source source, double sigma,
                                             bool gyro, double advanced_s = 0.0) noexcept;

/// z = (1 + ρ_x) (a_x - ψ̇² p_x) + b_ax; at standstill b_ax.
[[nodiscard]] Prediction predict_accel_x(const CarModel& model, const State& state,
                                         double sigma) noexcept;

/// z = (1 + ρ_y) (a_y + ψ̈ p_x - ψ̇² p_y) + b_ay with a_y = (v_y,k - v_y) / Δt + v_x ψ̇ and
/// ψ̈ = (ψ̇_k - ψ̇) / Δt, from the model's step over `dt`: a form of the tyre forces that holds at
/// any speed. Below the slowest speed that `dt` resolves, a_y is v_x ψ̇.
[[nodiscard]] Prediction predict_accel_y(const CarModel& model, const Input& input,
                                         const State& state, double sigma, double dt) noexcept;

}  // namespace odomd::estimator::full
