// docs/model.md, "Bounds".
#include "estimator/ekf/bounds.hpp"

#include <cmath>

#include <Eigen/Cholesky>

#include "estimator/common/pose.hpp"
#include "estimator/common/squares.hpp"

namespace odomd::estimator::full {
namespace {

// Beyond any car and sensor; larger numbers might overflow.
constexpr double largest_position = 1e9;
constexpr double largest_state = 1e4;

/// Larger deviations mean that nothing is known: half a turn, a kilometre, 100 m/s.
const Vector largest_deviation{{1e3, 1e3, 3.2, 1e2, 1e2, 35.0, 50.0, 1.0, 50.0, 10.0, 10.0, 0.5}};
const SlowVector largest_slow_error{{1.0, 0.5, 0.5, 0.1, 0.9, 1.0, 1.0, 0.3, 0.3, 0.3, 0.1, 1.0}};

/// P = L Lᵀ. A NaN or infinity anywhere in P makes some element of L's diagonal not finite.
template <typename Covariance>
bool is_positive_definite(const Covariance& P) noexcept {
  const Eigen::LLT<Covariance> factors(P);
  return factors.info() == Eigen::Success && factors.matrixLLT().diagonal().allFinite();
}

template <int Size>
void limit(Eigen::Matrix<double, Size, Size>& P,
           const Eigen::Matrix<double, Size, 1>& largest) noexcept {
  P.diagonal() *= rounding_inflation;
  for (Eigen::Index i = 0; i < Size; ++i) {
    if (P(i, i) > largest[i] * largest[i]) {
      const double factor = largest[i] / std::sqrt(P(i, i));
      P.row(i) *= factor;
      P.col(i) *= factor;
    }
  }
}

}  // namespace

void limit(State& state) noexcept {
  limit(state.covariance, largest_deviation);
  limit(state.slow.covariance, largest_slow_error);
  for (Eigen::Index j = 0; j < slow::size; ++j) {
    const Vector most = largest_deviation / std::sqrt(state.slow.covariance(j, j));
    state.slow.sensitivity.col(j) = state.slow.sensitivity.col(j).cwiseMax(-most).cwiseMin(most);
  }
}

bool is_valid(const State& state) noexcept {
  return state.mean.allFinite() && state.mean.head<2>().cwiseAbs().maxCoeff() < largest_position &&
         state.mean.tail<at::size - 3>().cwiseAbs().maxCoeff() < largest_state &&
         state.mean.segment<2>(at::v_x).cwiseAbs().maxCoeff() < fastest &&
         std::abs(state.mean[at::yaw_rate]) < fastest_turn && state.slow.mean.allFinite() &&
         state.slow.mean.cwiseAbs().maxCoeff() < largest_state &&
         state.slow.sensitivity.allFinite() && is_positive_definite(state.covariance) &&
         is_positive_definite(state.slow.covariance);
}

}  // namespace odomd::estimator::full
