// The accelerometers: specific force at the IMU's place (p_x, p_y), plus roll and pitch of the body
// in proportion to it.
//
// docs/model.md, "Accelerometers".
#pragma once

#include "estimator/ekf/process.hpp"
#include "estimator/ekf/update.hpp"

namespace odomd::estimator::full {

/// z = (1 + ρ_x) (a_x - ψ̇² p_x) + b_ax; at standstill b_ax.
[[nodiscard]] Prediction predict_accel_x(const CarModel& model, const State& state,
                                         double sigma) noexcept;

/// z = (1 + ρ_y) (a_y + ψ̈ p_x - ψ̇² p_y) + b_ay with a_y = (v_y,k - v_y) / Δt + v_x ψ̇ and
/// ψ̈ = (ψ̇_k - ψ̇) / Δt, by the model's step over `dt`: a form of the tyre forces that holds at any
/// speed. Below the slowest speed that `dt` resolves a_y is v_x ψ̇.
[[nodiscard]] Prediction predict_accel_y(const CarModel& model, const Input& input,
                                         const State& state, double sigma, double dt) noexcept;

}  // namespace odomd::estimator::full
