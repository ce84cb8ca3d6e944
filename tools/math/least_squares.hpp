// Solvers: nonlinear least squares (Levenberg and Marquardt) with priors, and with weights that
// reduce the effect of outliers (Huber, 1964); and bisection.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace odomd::tools {

inline constexpr double no_huber = std::numeric_limits<double>::infinity();

struct LeastSquares {
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;  ///< measured - predicted
  /// ∂predicted / ∂parameters; empty: finite differences with `step`.
  std::function<Eigen::MatrixXd(const Eigen::VectorXd&)> derivatives;
  Eigen::VectorXd step;
  Eigen::VectorXd start;
  Eigen::VectorXd expected;     ///< prior means of the parameters
  Eigen::VectorXd prior_sigma;  ///< their standard deviations; infinite: no prior
  double noise = 0.0;  ///< standard deviation of the residuals; 0: robust_sigma() of the residuals
  double huber = 2.0;  ///< residuals beyond this number of standard deviations lose weight
  /// Divides the residuals' information, as model errors are correlated over this number of
  /// residuals: counted as independent, they would outweigh the prior.
  double together = 1.0;
  double enough = 1e-2;  ///< stops after a step that lowers the cost by less
  int iterations = 30;
};

/// All members but the parameters are those at the start of the last step.
struct LeastSquaresSolution {
  Eigen::VectorXd parameters;
  Eigen::VectorXd residuals, weights;
  Eigen::MatrixXd derivatives;
  Eigen::MatrixXd from_data;  ///< information matrix of the residuals
  Eigen::MatrixXd inverse;    ///< of all information: the covariance if residuals are white
  double noise = 0.0;
  bool settled = false;  ///< false: stopped after all iterations
};

[[nodiscard]] LeastSquaresSolution solve(const LeastSquares& problem);

/// The objective of solve(): -2 ln of the likelihood and the priors, for residuals of this noise.
/// Infinite if a residual is NaN or infinite.
[[nodiscard]] double cost_of(const LeastSquares& problem, const Eigen::VectorXd& parameters,
                             double noise);

/// The trial of one parameter with the lowest cost; the other parameters stay at `start`.
[[nodiscard]] double best_of(const LeastSquares& problem, Eigen::Index parameter,
                             const std::vector<double>& trials, double noise);

/// The sandwich A⁻¹ (f Σ s sᵀ + P) A⁻¹ with A the information, P the priors' part of it, s the
/// score of each block and f `times`: residuals may be correlated within a block. Its diagonal is
/// at least that for independent residuals. `block` has the block of each residual, ascending.
[[nodiscard]] Eigen::MatrixXd covariance_by_blocks(const LeastSquares& problem,
                                                   const LeastSquaresSolution& found,
                                                   std::span<const std::size_t> block,
                                                   double times = 1.0);

/// The inverse of a symmetric matrix whose rows have different units.
[[nodiscard]] Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& information);

/// The point in [low, high] where the predicate becomes false, by bisection with `halvings` steps.
template <class Predicate>
[[nodiscard]] double bisect(double low, double high, int halvings, Predicate&& is_before) {
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (is_before(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace odomd::tools
