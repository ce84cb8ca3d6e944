// Automatic differentiation of the models, to check their analytic Jacobians.
#pragma once

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

namespace odomd::estimator::testing {

/// A scalar with its derivatives with respect to N variables.
template <int N>
using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, N, 1>>;

/// Variables `first` .. `first + Size - 1` of N, at `values`.
template <int N, int Size>
[[nodiscard]] Eigen::Matrix<Dual<N>, Size, 1> variables(
    const Eigen::Matrix<double, Size, 1>& values, int first) {
  Eigen::Matrix<Dual<N>, Size, 1> duals;
  for (int i = 0; i < Size; ++i) duals[i] = Dual<N>(values[i], N, first + i);
  return duals;
}

template <int N, int Size>
[[nodiscard]] Eigen::Matrix<double, Size, 1> values(const Eigen::Matrix<Dual<N>, Size, 1>& duals) {
  Eigen::Matrix<double, Size, 1> plain;
  for (int i = 0; i < Size; ++i) plain[i] = duals[i].value();
  return plain;
}

template <int N, int Size>
[[nodiscard]] Eigen::Matrix<double, Size, N> jacobian(
    const Eigen::Matrix<Dual<N>, Size, 1>& duals) {
  Eigen::Matrix<double, Size, N> matrix;
  for (int i = 0; i < Size; ++i) matrix.row(i) = duals[i].derivatives().transpose();
  return matrix;
}

}  // namespace odomd::estimator::testing
