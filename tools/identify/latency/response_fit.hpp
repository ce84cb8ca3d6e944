// Fits a few parameters of a numerically computed response: Levenberg and Marquardt by differences,
// with priors and with weights that take outliers out (Huber).
//
// The covariance is the sandwich A⁻¹ B A⁻¹, B summed over blocks of time, as in
// offset_regression.hpp.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace odomd::tools {

struct ResponseFit {
  std::vector<double> t;  ///< of the measurements [s], rising
  Eigen::VectorXd z;      ///< what was measured
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> predicted;  ///< z by the parameters
  Eigen::VectorXd expected;                                          ///< of the parameters, before
  Eigen::VectorXd prior_sigma;  ///< standard deviations of that
  Eigen::VectorXd start;        ///< where to begin
  double block = 2.0;           ///< residuals further apart are independent [s]
  /// This number of measurements counts as one against the prior: model errors are correlated
  /// between them, and must not outweigh the prior by their number.
  double together = 1.0;
};

struct FittedResponse {
  Eigen::VectorXd parameters;
  Eigen::MatrixXd covariance;
  double noise = 0.0;      ///< of the measurements, from the residuals
  double explained = 0.0;  ///< share of the variance of z
};

[[nodiscard]] FittedResponse fit(const ResponseFit& problem);

/// The objective of fit(): twice the negative logarithm of the likelihood and the priors, for
/// measurements of this noise.
[[nodiscard]] double cost_of(const ResponseFit& problem, const Eigen::VectorXd& parameters,
                             double noise);

/// Of `trials` for one parameter, all others as at the start, the one that fits best.
[[nodiscard]] double best_of(const ResponseFit& problem, Eigen::Index parameter,
                             const std::vector<double>& trials);

}  // namespace odomd::tools
