#include "estimator/full/bounds.hpp"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>

namespace odomd::estimator::full {
namespace {

// No car and no sensor gets here; numbers that do would overflow somewhere.
constexpr double largest_position = 1e9;
constexpr double largest_state = 1e4;
constexpr double fastest = 300.0;       // [m/s]
constexpr double fastest_turn = 100.0;  // [rad/s]

/// What nothing is known beyond: half a turn, a kilometre, 100 m/s.
constexpr std::array<double, at::size> largest_deviation{1e3,  1e3, 3.2, 1e2, 1e2, 35.0, 1e2, 1e2,
                                                         10.0, 0.5, 0.9, 1.0, 0.5, 10.0, 0.5};

// Rounding takes the last digits of a strongly correlated P; this keeps it positive definite, and
// makes it 1.7 % larger in a day.
constexpr double inflation = 1.0 + 1e-9;

}  // namespace

void limit(Matrix& P) noexcept {
  P.diagonal() *= inflation;
  for (Eigen::Index i = 0; i < at::size; ++i) {
    const double largest = largest_deviation[static_cast<std::size_t>(i)];
    if (P(i, i) > largest * largest) {
      const double factor = largest / std::sqrt(P(i, i));
      P.row(i) *= factor;
      P.col(i) *= factor;
    }
  }
}

bool sound(const State& state) noexcept {
  return state.mean.allFinite() && state.mean.head<2>().cwiseAbs().maxCoeff() < largest_position &&
         state.mean.tail<at::size - 3>().cwiseAbs().maxCoeff() < largest_state &&
         state.mean.segment<2>(at::v_x).cwiseAbs().maxCoeff() < fastest &&
         std::abs(state.mean[at::yaw_rate]) < fastest_turn && state.covariance.allFinite() &&
         Eigen::LLT<Matrix>(state.covariance).info() == Eigen::Success;
}

}  // namespace odomd::estimator::full
