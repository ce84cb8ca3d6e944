#include "tools/identify/latency/response_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double huber = 2.0;  // in standard deviations

double spread_of(const VectorXd& z) {
  return std::sqrt((z.array() - z.mean()).square().mean());
}

MatrixXd derivatives(const ResponseFit& problem, const VectorXd& p, const VectorXd& at_p) {
  MatrixXd jacobian(problem.z.size(), p.size());
  for (Index k = 0; k < p.size(); ++k) {
    const double h = 1e-3 * std::max(problem.prior_sigma[k], 1e-2);
    VectorXd up = p;
    up[k] += h;
    jacobian.col(k) = (problem.predicted(up) - at_p) / h;
  }
  return jacobian;
}

}  // namespace

double cost_of(const ResponseFit& problem, const VectorXd& p, double noise) {
  const VectorXd e = (problem.z - problem.predicted(p)).array().abs() / noise;
  if (!e.allFinite()) return std::numeric_limits<double>::infinity();
  double cost = 0.0;
  for (const double each : e)
    cost += each < huber ? each * each : 2.0 * huber * each - huber * huber;
  return cost / problem.together +
         ((p - problem.expected).array() / problem.prior_sigma.array()).square().sum();
}

double best_of(const ResponseFit& problem, Index parameter, const std::vector<double>& trials) {
  const double noise = std::max(0.2 * spread_of(problem.z), 1e-9);
  double best = std::numeric_limits<double>::infinity();
  double result = problem.start[parameter];
  for (const double trial : trials) {
    VectorXd p = problem.start;
    p[parameter] = trial;
    const double cost = cost_of(problem, p, noise);
    if (cost >= best) continue;
    best = cost;
    result = trial;
  }
  return result;
}

FittedResponse fit(const ResponseFit& problem) {
  FittedResponse result;
  VectorXd p = problem.start;
  const VectorXd prior = problem.prior_sigma.array().square().inverse();
  MatrixXd jacobian, from_data, information;
  VectorXd residual, weight;
  double damping = 1e-3;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const VectorXd now_predicted = problem.predicted(p);
    residual = problem.z - now_predicted;
    const double noise = std::max(1.4826 * median_of_magnitudes(residual), 1e-9);
    result.noise = noise;
    weight = (huber * noise / residual.array().abs().max(1e-300)).min(1.0);
    jacobian = derivatives(problem, p, now_predicted);
    const double variance = noise * noise * problem.together;
    from_data = jacobian.transpose() * weight.asDiagonal() * jacobian / variance;
    information = from_data;
    information.diagonal() += prior;
    const VectorXd gradient =
        jacobian.transpose() * (weight.array() * residual.array()).matrix() / variance +
        ((problem.expected - p).array() * prior.array()).matrix();
    const double now = cost_of(problem, p, noise);
    double gain = 0.0;
    for (int attempt = 0; attempt < 8; ++attempt) {
      MatrixXd damped = information;
      damped.diagonal() *= 1.0 + damping;
      const VectorXd trial = p + damped.ldlt().solve(gradient);
      const double cost = cost_of(problem, trial, noise);
      if (cost < now) {
        gain = now - cost;
        p = trial;
        damping = std::max(0.3 * damping, 1e-9);
        break;
      }
      damping *= 5.0;
    }
    if (gain < 1e-2) break;  // a tenth of a standard deviation, already taken
  }

  const double variance = result.noise * result.noise * problem.together;
  MatrixXd middle = MatrixXd(prior.asDiagonal());
  VectorXd score = VectorXd::Zero(p.size());
  double block_end = problem.t.front() + problem.block;
  for (Index i = 0; i < residual.size(); ++i) {
    const double t = problem.t[static_cast<std::size_t>(i)];
    if (t >= block_end) {
      middle += score * score.transpose();
      score.setZero();
      block_end = t + problem.block;
    }
    score += weight[i] * residual[i] / variance * jacobian.row(i).transpose();
  }
  middle += score * score.transpose();
  const MatrixXd bread = information.ldlt().solve(MatrixXd::Identity(p.size(), p.size()));
  result.covariance = bread * middle * bread;
  // Never more certain than independent residuals would be.
  const MatrixXd independent =
      bread * (from_data / problem.together + MatrixXd(prior.asDiagonal())) * bread;
  for (Index k = 0; k < p.size(); ++k)
    result.covariance(k, k) = std::max(result.covariance(k, k), independent(k, k));
  result.parameters = p;
  const double spread = spread_of(problem.z);
  if (spread > 0.0)
    result.explained = std::max(0.0, 1.0 - result.noise * result.noise / (spread * spread));
  return result;
}

}  // namespace odomd::tools
