#include "tools/identify/common/time_shift.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <set>

#include "tools/cli/text.hpp"
#include "tools/math/least_squares.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double grid_step = 5e-3;

// At least this share of the apparent information on the offset must be real rather than noise;
// otherwise the offset is arbitrary.
constexpr double least_known_share = 0.5;

/// The shifted functions at the time of every `every`-th sample.
MatrixXd design(const OffsetRegression& r, double offset, std::size_t every) {
  const std::size_t rows = (r.t.size() + every - 1) / every;
  return MatrixXd::NullaryExpr(static_cast<Index>(rows), static_cast<Index>(r.basis.size()),
                               [&](Index i, Index j) {
                                 return r.basis[static_cast<std::size_t>(j)].function.at(
                                     r.t[static_cast<std::size_t>(i) * every] - offset);
                               });
}

struct Linear {
  VectorXd coefficients;
  double cost = 0.0;
};

/// The coefficients, given the variance of the residuals, which sets the weight of the priors.
Linear solve_linear(const LeastSquares& priors, const MatrixXd& x, const VectorXd& y,
                    double variance) {
  const auto basis = x.cols();
  const VectorXd prior = priors.prior_sigma.head(basis).array().square().inverse() * variance;
  const VectorXd expected = priors.expected.head(basis);
  MatrixXd a = x.transpose() * x;
  a.diagonal() += prior;
  Linear result;
  result.coefficients = inverse_of(a) * (x.transpose() * y + prior.cwiseProduct(expected));
  result.cost = (y - x * result.coefficients).squaredNorm() +
                (result.coefficients - expected).cwiseAbs2().dot(prior);
  return result;
}

}  // namespace

std::vector<std::size_t> blocks_of(const std::vector<double>& t, double length) {
  std::vector<std::size_t> block;
  for (const double time : t)
    block.push_back(static_cast<std::size_t>((time - t.front()) / length));
  return block;
}

Offset solve(const OffsetRegression& r) {
  Offset result;
  if (r.t.size() < 20) {
    result.failure = "only " + counted(r.t.size(), "sample");
    return result;
  }
  const Eigen::Map<const VectorXd> y(r.y.data(), static_cast<Index>(r.y.size()));
  const std::size_t every = std::max<std::size_t>(1, r.t.size() / 3000);
  const VectorXd thin = y(Eigen::seq(0, Eigen::last, static_cast<Index>(every)));
  const double spread = (thin.array() - thin.mean()).square().mean();
  if (!(spread > 0.0)) {
    result.failure = "the signal never changes";
    return result;
  }
  // The coefficients, then the offset, which has no prior.
  const auto basis = static_cast<Index>(r.basis.size());
  LeastSquares problem{.enough = 1e-9};
  problem.expected = VectorXd::Zero(basis + 1);
  problem.prior_sigma = VectorXd::Constant(basis + 1, std::numeric_limits<double>::infinity());
  for (Index j = 0; j < basis; ++j) {
    problem.expected[j] = r.basis[static_cast<std::size_t>(j)].expected;
    problem.prior_sigma[j] = r.basis[static_cast<std::size_t>(j)].sigma;
  }
  problem.residuals = [&](const VectorXd& p) -> VectorXd {
    return y - design(r, p[basis], 1) * p.head(basis);
  };
  problem.derivatives = [&](const VectorXd& p) {
    constexpr double h = 4e-3;
    const VectorXd rate =
        (design(r, p[basis] + h, 1) - design(r, p[basis] - h, 1)) / (2.0 * h) * p.head(basis);
    MatrixXd all(y.size(), basis + 1);
    all << design(r, p[basis], 1), rate;
    return all;
  };

  // The noise, which sets the weight of the priors: first a guess, then from the best offset.
  double noise = 0.05 * spread, offset = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    double best = std::numeric_limits<double>::infinity();
    const int steps = static_cast<int>(std::lround(r.range / grid_step));
    VectorXd residual;
    for (int k = -steps; k <= steps; ++k) {
      const MatrixXd x = design(r, k * grid_step, every);
      const Linear fit = solve_linear(problem, x, thin, noise);
      if (fit.cost >= best) continue;
      best = fit.cost;
      offset = k * grid_step;
      residual = thin - x * fit.coefficients;
    }
    noise = std::max(std::pow(robust_sigma(residual), 2), 1e-12 * spread);
  }
  problem.start = VectorXd::Constant(basis + 1, offset);
  problem.start.head(basis) = solve_linear(problem, design(r, offset, 1), y, noise).coefficients;
  const LeastSquaresSolution found = solve(problem);
  result.value = found.parameters[basis];
  result.coefficients.assign(found.parameters.data(), found.parameters.data() + basis);
  const double variance = found.noise * found.noise;
  result.explained = std::max(0.0, 1.0 - variance / spread);

  const std::vector<std::size_t> block = blocks_of(r.t, r.block);
  const auto blocks = static_cast<double>(std::set(block.begin(), block.end()).size());
  const double few_blocks = blocks > 4.0 ? blocks / (blocks - 2.0) : 4.0;
  const MatrixXd covariance = covariance_by_blocks(problem, found, block, few_blocks);
  const double known_share = 1.0 - found.weights.sum() * result.coefficients[0] *
                                       result.coefficients[0] * r.slope_noise *
                                       found.inverse(basis, basis) / variance;
  result.sigma = std::sqrt(covariance(basis, basis)) / std::max(known_share, 0.1);

  if (std::fabs(result.value) > r.range - 2.0 * grid_step)
    result.failure = "no offset within " + fixed(r.range, 1) + " s makes them agree";
  else if (known_share < least_known_share)
    result.failure =
        "too little excitation compared with the noise; drive with more turns and stops";
  else if (result.explained < 0.3)
    result.failure = "the two signals have too little in common: excitation, sign, mapping?";
  return result;
}

}  // namespace odomd::tools
