// docs/model.md, "Bounds".
#include "estimator/ekf/bounds.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/common/pose.hpp"
#include "estimator/common/squares.hpp"

namespace odomd::estimator::full {
namespace {

// Beyond any car and sensor; larger numbers might overflow.
constexpr double largest_position = 1e9;
constexpr double largest_state = 1e4;

/// Larger deviations mean that nothing is known: half a turn, a kilometre, 100 m/s.
constexpr std::array<double, at::size> largest_deviation{1e3,  1e3, 3.2,  1e2,  1e2,  35.0,
                                                         50.0, 1.0, 50.0, 10.0, 10.0, 0.5};
constexpr std::array<double, slow::size> largest_slow_error{1.0, 0.5, 0.5, 0.1, 0.9, 1.0,
                                                            1.0, 0.3, 0.3, 0.3, 0.1, 1.0};

/// P = L D Lᵀ with all of D finite and positive. A NaN or infinity anywhere in P makes some element
/// of D not finite.
template <typename Covariance>
bool is_positive_definite(Covariance P) noexcept {
  for (Eigen::Index k = 0; k < P.cols(); ++k) {
    const double d = P(k, k);
    if (!(d > 0.0) || !std::isfinite(d)) {
      return false;
    }
    for (Eigen::Index j = k + 1; j < P.cols(); ++j) {
      P.col(j) -= P(j, k) / d * P.col(k);
    }
  }
  return true;
}

template <int Size, std::size_t Count>
void limit(Eigen::Matrix<double, Size, Size>& P, const std::array<double, Count>& most) noexcept {
  static_assert(Size == Count);
  P.diagonal() *= rounding_inflation;
  for (Eigen::Index i = 0; i < Size; ++i) {
    const double largest = most[static_cast<std::size_t>(i)];
    if (P(i, i) > largest * largest) {
      const double factor = largest / std::sqrt(P(i, i));
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
    const double sigma = std::sqrt(state.slow.covariance(j, j));
    for (Eigen::Index i = 0; i < at::size; ++i) {
      const double most = largest_deviation[static_cast<std::size_t>(i)] / sigma;
      double& by = state.slow.sensitivity(i, j);
      by = std::clamp(by, -most, most);
    }
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
