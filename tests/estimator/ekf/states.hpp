// Test states of the full filter.
#pragma once

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full::testing {

/// All slow errors nonzero.
inline SlowVector some_slow_values() {
  SlowVector errors;
  errors << 0.02, 0.01, 0.015, 0.004, -0.2, 0.07, -0.03, 0.02, -0.015, 0.01, 0.004, 0.03;
  return errors;
}

/// States at rest, forward and in reverse, straight and at full lock; other components are nonzero.
inline std::vector<State> grid_of_states() {
  std::vector<State> states;
  for (const double v_x : {-3.0, -0.4, -0.1, 0.0, 0.003, 0.1, 1.0, 4.0, 20.0}) {
    for (const double v_y : {-0.3, 0.0, 0.2}) {
      for (const double yaw_rate : {-2.0, 0.0, 1.5}) {
        for (const double steering : {-0.45, 0.0, 0.45}) {
          State state;
          state.mean << 3.0, -2.0, 0.7, v_x, v_y, yaw_rate, 0.6, 0.1, 0.5, -0.08, 0.02, 0.01;
          state.slow.mean = some_slow_values();
          state.steering = {true, 0, steering};
          state.front_wheels = steering;
          state.accel_x = {true, 0, 0.8};
          states.push_back(state);
        }
      }
    }
  }
  return states;
}

/// Numbers of either sign, all of them different; the same every time.
template <typename Made>
Made some_numbers(int seed = 13) {
  Made numbers;
  for (Eigen::Index i = 0; i < numbers.size(); ++i)
    numbers(i) = static_cast<double>((i * 7919 + seed) % 101) / 50.0 - 1.0;
  return numbers;
}

/// Positive definite, with all entries correlated; symmetric to the bit.
template <typename Square = Matrix>
Square some_covariance(double size = 1e-2) {
  const auto root = some_numbers<Square>();
  const Square product = size * (root * root.transpose() / root.rows() + 0.1 * Square::Identity());
  return 0.5 * (product + product.transpose());
}

/// Slow errors with an effect on every state.
inline SlowErrors some_slow_errors(double size = 1e-2) {
  SlowErrors some;
  some.mean = some_slow_values();
  some.covariance = some_covariance<SlowMatrix>(size);
  some.sensitivity = some_numbers<decltype(some.sensitivity)>(29);
  return some;
}

inline constexpr int joint_size = int{at::size} + int{slow::size};
using JointMatrix = Eigen::Matrix<double, joint_size, joint_size>;

/// The covariance of states and slow errors as one joint state.
inline JointMatrix joint_covariance(const State& state) {
  const auto& B = state.slow.sensitivity;
  const SlowMatrix& P_s = state.slow.covariance;
  JointMatrix P;
  P << state.covariance + B * P_s * B.transpose(), B * P_s, P_s * B.transpose(), P_s;
  return P;
}

/// Positive definite, and symmetric to the bit, as after every update.
template <typename Square>
bool is_covariance(const Square& P) {
  return P.allFinite() && P == P.transpose() && Eigen::LLT<Square>(P).info() == Eigen::Success;
}
inline bool has_covariances(const State& state) {
  return is_covariance(state.covariance) && is_covariance(state.slow.covariance);
}

/// The largest absolute value in a matrix.
template <typename Derived>
double largest(const Eigen::MatrixBase<Derived>& matrix) {
  return matrix.cwiseAbs().maxCoeff();
}

}  // namespace odomd::estimator::full::testing
