// Compares the derivatives of a prediction, and of a step of the process, with central differences.
#pragma once

#include <initializer_list>

#include "estimator/ekf/process_model.hpp"
#include "estimator/ekf/state.hpp"
#include "estimator/ekf/update.hpp"
#include "tests/estimator/ekf/states.hpp"
#include "tests/gtest.hpp"

namespace odomd::estimator::full::testing {

/// ∂h/∂x as the prediction states it.
inline Vector stated(const Prediction& prediction) {
  Vector by = Vector::Zero();
  for (std::size_t i = 0; i < prediction.count(); ++i) {
    by[prediction.state(i)] += prediction.by(i);
  }
  return by;
}

/// The derivatives of a prediction with respect to a vector of the state, from central differences.
/// `predict` maps a State to its Prediction.
template <typename Made, typename Predict, typename Select>
Made differences_by(const State& at, const Predict& predict, const Select& select) {
  constexpr double step = 1e-6;
  Made by;
  for (Eigen::Index i = 0; i < by.size(); ++i) {
    State above = at;
    State below = at;
    select(above)[i] += step;
    select(below)[i] -= step;
    by[i] = (predict(above).value - predict(below).value) / (2.0 * step);
  }
  return by;
}

/// ∂h/∂x.
template <typename Predict>
Vector differences(const State& at, const Predict& predict) {
  return differences_by<Vector>(at, predict, [](State& s) -> Vector& { return s.mean; });
}

/// ∂h/∂s.
template <typename Predict>
SlowVector differences_by_slow(const State& at, const Predict& predict) {
  return differences_by<SlowVector>(
      at, predict, [](State & s) -> auto& { return s.slow.mean; });
}

/// Expects the derivatives that a prediction states to be right within `tolerance` times the
/// largest of them, or times 1. The prediction must state 0 for the states `left_out`.
template <typename Predict>
void expect_derivatives(const State& at, const Predict& predict, double tolerance,
                        std::initializer_list<at::Index> left_out = {}) {
  const Prediction z = predict(at);
  Vector expected = differences(at, predict);
  for (const at::Index state : left_out) expected[state] = 0.0;
  EXPECT_LT(largest(stated(z) - expected), tolerance * std::max(1.0, largest(expected)))
      << at.mean.transpose();
  EXPECT_LT(largest(z.by_slow - differences_by_slow(at, predict)),
            tolerance * std::max(1.0, largest(z.by_slow)))
      << at.mean.transpose();
}

/// The effect of propagate() at a state: x' = f(x, s), F, ∂f/∂s, and the additions to the
/// covariances.
struct LinearStep {
  Vector mean = Vector::Zero();
  Matrix F = Matrix::Zero();
  Eigen::Matrix<double, at::size, slow::size> by_slow =
      Eigen::Matrix<double, at::size, slow::size>::Zero();
  Matrix noise = Matrix::Zero();
  SlowMatrix slow_noise = SlowMatrix::Zero();
};

/// The step B ← F B + ∂f/∂s gives ∂f/∂s if B = 0, and the columns of F if B has unit vectors.
inline LinearStep linear_step(const CarModel& model, const Input& input, double dt, State state) {
  state.covariance.setZero();
  const double softness = state.variance(slow::softness);  // the noise depends on this
  state.slow.covariance.setZero();
  state.variance(slow::softness) = softness;
  state.slow.sensitivity.setZero();
  const auto stepped = [&](const auto& change) {
    State after = state;
    change(after);
    propagate(model, input, dt, after);
    return after;
  };
  const State plain = stepped([](State&) {});
  LinearStep step{.mean = plain.mean,
                  .by_slow = plain.slow.sensitivity,
                  .noise = plain.covariance,
                  .slow_noise = plain.slow.covariance - state.slow.covariance};
  for (Eigen::Index i = 0; i < at::size; ++i) {
    const State after =
        stepped([i](State& changed) { changed.slow.sensitivity(i, slow::gyro_bias) = 1.0; });
    step.F.col(i) =
        after.slow.sensitivity.col(slow::gyro_bias) - plain.slow.sensitivity.col(slow::gyro_bias);
  }
  return step;
}

}  // namespace odomd::estimator::full::testing
