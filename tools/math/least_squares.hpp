// Nonlinear least squares by Levenberg and Marquardt, with priors and with weights that take
// outliers out (Huber, 1964).
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
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;  ///< measured less predicted
  /// The derivatives of what is predicted by the parameters; empty: by differences of `step`.
  std::function<Eigen::MatrixXd(const Eigen::VectorXd&)> derivatives;
  Eigen::VectorXd step;
  Eigen::VectorXd start;
  Eigen::VectorXd expected;     ///< of the parameters, before
  Eigen::VectorXd prior_sigma;  ///< standard deviations of that; infinite: nothing is known
  double noise = 0.0;           ///< of the residuals; 0: from themselves, by their median
  double huber = 2.0;           ///< beyond it, in standard deviations, residuals lose weight
  /// This number of residuals counts as one against the prior: model errors are correlated between
  /// them, and must not outweigh the prior by their number.
  double together = 1.0;
  double enough = 1e-2;  ///< ends with a step that lowers the cost by less
  int iterations = 30;
};

/// All but the parameters as of the last step's begin.
struct LeastSquaresSolution {
  Eigen::VectorXd parameters;
  Eigen::VectorXd residuals, weights;
  Eigen::MatrixXd derivatives;
  Eigen::MatrixXd from_data;  ///< information of the residuals
  Eigen::MatrixXd inverse;    ///< of the whole information: the covariance for white residuals
  double noise = 0.0;
  bool settled = false;  ///< or out of iterations
};

[[nodiscard]] LeastSquaresSolution solve(const LeastSquares& problem);

/// The objective of solve(): twice the negative logarithm of the likelihood and the priors, for
/// residuals of this noise. Infinite where a residual is no number.
[[nodiscard]] double cost_of(const LeastSquares& problem, const Eigen::VectorXd& parameters,
                             double noise);

/// Of `trials` for one parameter, all others as at the start, the one of the least cost.
[[nodiscard]] double best_of(const LeastSquares& problem, Eigen::Index parameter,
                             const std::vector<double>& trials, double noise);

/// The sandwich A⁻¹ (f Σ s sᵀ + P) A⁻¹ with A the information, P the priors' part of it and s the
/// scores of each block: residuals that hang together within a block count as what they are, not as
/// independent. Its diagonal is never less than that of independent residuals. `block` numbers the
/// block of each residual, ascending; f is `times`.
[[nodiscard]] Eigen::MatrixXd covariance_by_blocks(const LeastSquares& problem,
                                                   const LeastSquaresSolution& found,
                                                   std::span<const std::size_t> block,
                                                   double times = 1.0);

/// The inverse of a symmetric matrix whose rows have different units.
[[nodiscard]] Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& information);

}  // namespace odomd::tools
