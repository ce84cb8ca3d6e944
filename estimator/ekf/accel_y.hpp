// The lateral accelerometer: what the tyres push, at the place of the IMU.
#pragma once

#include "estimator/ekf/model.hpp"
#include "estimator/ekf/prediction.hpp"

namespace odomd::estimator::full {

/// z = (v_y,k - v_y) / Δt + v_x ψ̇ + ψ̈ p_x - ψ̇² p_y + b_ay, with the step of the model over `dt`:
/// its side force over m, in the form that holds at any speed, and ψ̈ = (ψ̇_k - ψ̇) / Δt. (p_x, p_y)
/// is the IMU's lever arm. Below the slowest speed that `dt` resolves the force is not modelled,
/// and only b_ay is learnt.
[[nodiscard]] Prediction predict_accel_y(const CarModel& model, const Input& input,
                                         const State& state, double sigma, double dt) noexcept;

}  // namespace odomd::estimator::full
