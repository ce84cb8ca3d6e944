// docs/model.md, "Consensus".
#include "estimator/integrity/consensus.hpp"

#include <cmath>

namespace odomd::estimator::integrity {

Solution Consensus::without(Sources left_out) const noexcept {
  // N = Σ a aᵀ / σ², b = Σ a z / σ², x = N⁻¹ b
  Eigen::Matrix<double, of::size, of::size> N = Eigen::Matrix<double, of::size, of::size>::Zero();
  Motion b = Motion::Zero();
  for (const Row& row : *this) {
    if ((row.sources & left_out) == 0) {
      const Motion weighed = row.by / (row.sigma * row.sigma);
      N += row.by * weighed.transpose();
      b += weighed * row.z;
    }
  }
  const Eigen::LLT<Eigen::Matrix<double, of::size, of::size>> factors(N);
  Solution solution;
  solution.motion = factors.solve(b);
  for (Eigen::Index i = 0; i < of::size; ++i) {
    solution.sigma[i] = std::sqrt(factors.solve(Motion::Unit(i))[i]);
  }
  for (const Row& row : *this) {
    if ((row.sources & left_out) == 0) {
      const double residual = row.off(solution.motion);
      solution.misfit += residual * residual;
    }
  }
  return solution;
}

}  // namespace odomd::estimator::integrity
