// What a scalar sample should read at a state, how that depends on the state, and the update of
// mean and covariance by it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full {

/// h(x), the row ∂h/∂x by its entries that are not zero, and R: the variance of the sample about
/// h(x), its own noise and what the model leaves out.
class Prediction {
 public:
  double value = 0.0;
  double variance = 0.0;

  /// Adds `by` to ∂h/∂(state).
  void depends_on(at::Index state, double by) noexcept {
    states_[count_] = state;
    by_[count_] = by;
    ++count_;
  }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] at::Index state(std::size_t i) const noexcept { return states_[i]; }
  [[nodiscard]] double by(std::size_t i) const noexcept { return by_[i]; }

 private:
  std::array<at::Index, 8> states_{};
  std::array<double, 8> by_{};
  std::size_t count_ = 0;
};

/// The innovation ν = z - h(x) and its variance S = H P Hᵀ + R, with the gain's P Hᵀ.
struct Innovation {
  double value = 0.0;
  double variance = 1.0;
  Vector covariance_with_state = Vector::Zero();

  /// νᵀ S⁻¹ ν: χ² with one degree of freedom where the filter is consistent.
  [[nodiscard]] double squared_ratio() const noexcept { return value * value / variance; }
};

[[nodiscard]] inline Innovation innovation(const State& state, const Prediction& prediction,
                                           double measured) noexcept {
  Innovation nu;
  nu.value = measured - prediction.value;
  nu.variance = prediction.variance;
  for (std::size_t i = 0; i < prediction.count(); ++i) {
    nu.covariance_with_state += prediction.by(i) * state.covariance.col(prediction.state(i));
  }
  for (std::size_t i = 0; i < prediction.count(); ++i) {
    nu.variance += prediction.by(i) * nu.covariance_with_state[prediction.state(i)];
  }
  return nu;
}

/// x ← x + K ν, P ← (I - K H) P (I - K H)ᵀ + K R Kᵀ: Joseph's form, right for any gain. With
/// a = P Hᵀ and b = a - S K / 2 it is P - K bᵀ - b Kᵀ, symmetric to the bit.
inline void correct(State& state, const Innovation& nu, const Vector& gain) noexcept {
  const Vector b = nu.covariance_with_state - (0.5 * nu.variance) * gain;
  for (Eigen::Index j = 0; j < at::size; ++j) {
    state.covariance.col(j) -= gain * b[j] + b * gain[j];
  }
  state.mean += gain * nu.value;
}

/// What is known of one of the states becomes `sigma`, and nothing else is related to it.
inline void forget(State& state, at::Index index, double sigma) noexcept {
  state.covariance.row(index).setZero();
  state.covariance.col(index).setZero();
  state.covariance(index, index) = sigma * sigma;
}

/// K = P Hᵀ / S: for what teaches everything.
[[nodiscard]] inline Vector optimal_gain(const Innovation& nu) noexcept {
  return nu.covariance_with_state / nu.variance;
}

/// What a sample of the car's own sensors may teach beside velocity, forces and its own bias.
struct Teaches {
  bool yaw_rate = false;   ///< ψ̇: a gyro; without one, the wheels
  bool gyro_bias = false;  ///< b_g: a gyro whose car stands
};

/// The gain of the car's own sensors, of a source that was not heard for `unheard_s`: the optimal
/// one, but (Schmidt's consider states, docs/model.md)
///   the pose moves by what the corrected velocity makes of the time since the source was last
///   heard, taken that the error has grown evenly, and by no more;
///   the scales of sensors and tyres stay; ψ̇ and b_g where they are not taught.
/// What wheels, accelerometer and tyre model say among themselves of these rests on a model that is
/// no better than what it would correct. A camera teaches everything.
[[nodiscard]] inline Vector gain_of_own_sensors(const State& state, const Innovation& nu,
                                                double unheard_s, Teaches teaches) noexcept {
  Vector gain = optimal_gain(nu);
  if (!teaches.yaw_rate) {
    gain[at::yaw_rate] = 0.0;
  }
  if (!teaches.gyro_bias) {
    gain[at::gyro_bias] = 0.0;
  }
  gain[at::stiffness_scale] = 0.0;
  gain[at::gyro_scale] = 0.0;
  gain[at::wheel_scale] = 0.0;
  const double half = 0.5 * unheard_s;
  const double c = std::cos(state.mean[at::yaw]);
  const double s = std::sin(state.mean[at::yaw]);
  gain[at::x] = half * (c * gain[at::v_x] - s * gain[at::v_y]);
  gain[at::y] = half * (s * gain[at::v_x] + c * gain[at::v_y]);
  gain[at::yaw] = half * gain[at::yaw_rate];
  return gain;
}

}  // namespace odomd::estimator::full
