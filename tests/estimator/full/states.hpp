// States of the full filter to try things at.
#pragma once

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "estimator/ekf/state.hpp"

namespace odomd::estimator::full::testing {

/// Standing, forward and in reverse, straight and at full lock, every other state off its zero.
inline std::vector<State> grid_of_states() {
  std::vector<State> states;
  for (const double v_x : {-3.0, -0.4, -0.1, 0.0, 0.003, 0.1, 1.0, 4.0, 20.0}) {
    for (const double v_y : {-0.3, 0.0, 0.2}) {
      for (const double yaw_rate : {-2.0, 0.0, 1.5}) {
        for (const double steering : {-0.45, 0.0, 0.45}) {
          State state;
          state.mean << 3.0, -2.0, 0.7, v_x, v_y, yaw_rate, 0.6, 0.4, 0.1, 0.01, -0.08, 0.02, 0.01,
              -0.2, 0.015;
          state.steering = {true, 0, steering};
          state.accel_x = {true, 0, 0.8};
          states.push_back(state);
        }
      }
    }
  }
  return states;
}

/// Positive definite, everything correlated with everything; symmetric to the bit.
inline Matrix some_covariance(double size = 1e-2) {
  Matrix root;
  for (Eigen::Index i = 0; i < root.size(); ++i) {
    root(i) = static_cast<double>((i * 7919 + 13) % 101) / 50.0 - 1.0;
  }
  const Matrix product = size * (root * root.transpose() / at::size + 0.1 * Matrix::Identity());
  return 0.5 * (product + product.transpose());
}

/// Not nearly so, and symmetric to the bit: what every covariance must be after every update.
inline bool is_covariance(const Matrix& P) {
  return P.allFinite() && P == P.transpose() && Eigen::LLT<Matrix>(P).info() == Eigen::Success;
}

}  // namespace odomd::estimator::full::testing
