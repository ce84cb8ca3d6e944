#include "tools/math/least_squares.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double least_noise = 1e-9;

VectorXd prior_of(const LeastSquares& problem) {
  return problem.prior_sigma.array().square().inverse();  // 0 for infinite sigmas
}

double cost_of_residuals(const LeastSquares& problem, const VectorXd& residuals, const VectorXd& p,
                         double noise) {
  if (!residuals.allFinite()) return std::numeric_limits<double>::infinity();
  double cost = 0.0;
  for (const double residual : residuals) {
    const double e = std::fabs(residual) / noise;
    cost += e < problem.huber ? e * e : 2.0 * problem.huber * e - problem.huber * problem.huber;
  }
  return cost / problem.together +
         ((p - problem.expected).array() / problem.prior_sigma.array()).square().sum();
}

MatrixXd derivatives_of(const LeastSquares& problem, const VectorXd& p, const VectorXd& residuals) {
  if (problem.derivatives) return problem.derivatives(p);
  MatrixXd result(residuals.size(), p.size());
  for (Index k = 0; k < p.size(); ++k) {
    VectorXd up = p;
    up[k] += problem.step[k];
    result.col(k) = (residuals - problem.residuals(up)) / problem.step[k];
  }
  return result;
}

}  // namespace

MatrixXd inverse_of(const MatrixXd& information) {
  // Scaled to a unit diagonal, as the rows have different units.
  const VectorXd scale = information.diagonal().unaryExpr(
      [](double value) { return value > 0.0 ? 1.0 / std::sqrt(value) : 1.0; });
  MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  scaled.diagonal().array() += 1e-12;
  const MatrixXd inverse = scaled.ldlt().solve(MatrixXd::Identity(scaled.rows(), scaled.cols()));
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

double cost_of(const LeastSquares& problem, const VectorXd& parameters, double noise) {
  return cost_of_residuals(problem, problem.residuals(parameters), parameters, noise);
}

double best_of(const LeastSquares& problem, Index parameter, const std::vector<double>& trials,
               double noise) {
  VectorXd p = problem.start;
  double best = std::numeric_limits<double>::infinity(), result = p[parameter];
  for (const double trial : trials) {
    p[parameter] = trial;
    const double cost = cost_of(problem, p, noise);
    if (cost >= best) continue;
    best = cost;
    result = trial;
  }
  return result;
}

LeastSquaresSolution solve(const LeastSquares& problem) {
  LeastSquaresSolution result;
  VectorXd& p = result.parameters;
  p = problem.start;
  const VectorXd prior = prior_of(problem);
  VectorXd residuals = problem.residuals(p);
  MatrixXd information;
  double damping = 1e-3;
  for (int iteration = 0; iteration < problem.iterations && !result.settled; ++iteration) {
    result.residuals = residuals;
    const double noise =
        problem.noise > 0.0 ? problem.noise : std::max(robust_sigma(residuals), least_noise);
    result.noise = noise;
    result.weights = (problem.huber * noise / residuals.array().abs().max(1e-300)).min(1.0);
    result.derivatives = derivatives_of(problem, p, residuals);
    const double variance = noise * noise * problem.together;
    const MatrixXd weighted = result.weights.asDiagonal() * result.derivatives;
    result.from_data = weighted.transpose() * result.derivatives / variance;
    information = result.from_data;
    information.diagonal() += prior;
    const VectorXd gradient = weighted.transpose() * residuals / variance +
                              ((problem.expected - p).array() * prior.array()).matrix();
    const double now = cost_of_residuals(problem, residuals, p, noise);
    double gain = 0.0;
    for (int attempt = 0; attempt < 8; ++attempt) {
      MatrixXd damped = information;
      damped.diagonal() *= 1.0 + damping;
      const VectorXd trial = p + damped.ldlt().solve(gradient);
      const VectorXd left = problem.residuals(trial);
      const double cost = cost_of_residuals(problem, left, trial, noise);
      if (cost < now) {
        gain = now - cost;
        p = trial;
        residuals = left;
        damping = std::max(0.3 * damping, 1e-9);
        break;
      }
      damping *= 5.0;
    }
    result.settled = gain < problem.enough;
  }
  result.inverse = inverse_of(information);
  return result;
}

MatrixXd covariance_by_blocks(const LeastSquares& problem, const LeastSquaresSolution& found,
                              std::span<const std::size_t> block, double times) {
  const MatrixXd prior = prior_of(problem).asDiagonal();
  const double variance = found.noise * found.noise * problem.together;
  const VectorXd pull = found.weights.cwiseProduct(found.residuals) / variance;
  MatrixXd scores = MatrixXd::Zero(prior.rows(), prior.cols());
  for (std::size_t begin = 0, end = 0; begin < block.size(); begin = end) {
    while (end < block.size() && block[end] == block[begin]) ++end;
    const auto first = static_cast<Index>(begin), count = static_cast<Index>(end - begin);
    const VectorXd score =
        found.derivatives.middleRows(first, count).transpose() * pull.segment(first, count);
    scores += score * score.transpose();
  }
  MatrixXd covariance = found.inverse * (times * scores + prior) * found.inverse;
  const MatrixXd independent =
      found.inverse * (found.from_data / problem.together + prior) * found.inverse;
  covariance.diagonal() = covariance.diagonal().cwiseMax(independent.diagonal());
  return covariance;
}

}  // namespace odomd::tools
