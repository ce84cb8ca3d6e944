// Fits a few parameters of a numerically computed response (tools/math/least_squares.hpp), their
// covariance by blocks of time.
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
  double together = 1.0;        ///< measurements that count as one against the prior
};

struct FittedResponse {
  Eigen::VectorXd parameters;
  Eigen::MatrixXd covariance;
  double noise = 0.0;      ///< of the measurements, from the residuals
  double explained = 0.0;  ///< share of the variance of z
};

[[nodiscard]] FittedResponse fit(const ResponseFit& problem);

/// The objective of fit() for measurements of this noise.
[[nodiscard]] double cost_of(const ResponseFit& problem, const Eigen::VectorXd& parameters,
                             double noise);

/// Of `trials` for one parameter, all others as at the start, the one that fits best.
[[nodiscard]] double best_of(const ResponseFit& problem, Eigen::Index parameter,
                             const std::vector<double>& trials);

}  // namespace odomd::tools
