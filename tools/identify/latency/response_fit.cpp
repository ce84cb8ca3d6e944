#include "tools/identify/latency/response_fit.hpp"

#include <algorithm>
#include <cmath>

#include "tools/math/least_squares.hpp"

namespace odomd::tools {
namespace {

using Eigen::VectorXd;

double spread_of(const VectorXd& z) {
  return std::sqrt((z.array() - z.mean()).square().mean());
}

LeastSquares least_squares(const ResponseFit& fit) {
  return {.residuals = [&fit](const VectorXd& p) -> VectorXd { return fit.z - fit.predicted(p); },
          .step = 1e-3 * fit.prior_sigma.cwiseMax(1e-2),
          .start = fit.start,
          .expected = fit.expected,
          .prior_sigma = fit.prior_sigma,
          .together = fit.together};
}

}  // namespace

double cost_of(const ResponseFit& fit, const VectorXd& parameters, double noise) {
  return cost_of(least_squares(fit), parameters, noise);
}

double best_of(const ResponseFit& fit, Eigen::Index parameter, const std::vector<double>& trials) {
  return best_of(least_squares(fit), parameter, trials, std::max(0.2 * spread_of(fit.z), 1e-9));
}

FittedResponse fit(const ResponseFit& fit) {
  const LeastSquares problem = least_squares(fit);
  const LeastSquaresSolution found = solve(problem);
  std::vector<std::size_t> block;
  double end = fit.t.front() + fit.block;
  for (const double t : fit.t) {
    block.push_back(block.empty() ? 0 : block.back() + (t >= end ? 1 : 0));
    if (t >= end) end = t + fit.block;
  }
  const double spread = spread_of(fit.z);
  return {.parameters = found.parameters,
          .covariance = covariance_by_blocks(problem, found, block),
          .noise = found.noise,
          .explained = spread > 0.0 ? std::max(0.0, 1.0 - std::pow(found.noise / spread, 2)) : 0.0};
}

}  // namespace odomd::tools
