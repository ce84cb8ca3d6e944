#include "tools/identify/fit/problem.hpp"

#include <ceres/crs_matrix.h>
#include <ceres/manifold.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tools/identify/fit/cost.hpp"

namespace odomd::tools::fitting {
namespace {

constexpr double latency_stride = 0.03;  // in a pass [s]

}  // namespace

Measured Settings::known(std::size_t k) const {
  if (k != gyro_bias || !rest) return {0.0, prior_sigma[k]};
  const double by_rest = 1.0 / (rest->sigma * rest->sigma),
               all = by_rest + 1.0 / (prior_sigma[k] * prior_sigma[k]);
  return {rest->value * by_rest / all, 1.0 / std::sqrt(all)};
}

Built build(const Setup& setup, const Settings& settings, Numbers<double>& p,
            std::vector<Chain>& chains) {
  Built built;
  built.problem = std::make_unique<ceres::Problem>();
  built.unknowns.push_back(p.data());
  std::size_t cluster = 0;
  const auto per_cluster = std::max<std::size_t>(
      1, static_cast<std::size_t>(std::lround(settings.cluster / setup.window)));
  for (Chain& chain : chains) {
    for (std::size_t w = 0; w < chain.windows.size(); ++w) {
      if (w % per_cluster == 0) ++cluster;
      built.blocks.push_back(built.problem->AddResidualBlock(
          window_cost(setup, chain.windows[w], settings.free).release(), nullptr, p.data(),
          chain.nodes[w].data(), chain.inner[w].data(), chain.nodes[w + 1].data()));
      built.cluster.push_back(cluster);
      built.unknowns.push_back(chain.nodes[w].data());
      built.unknowns.push_back(chain.inner[w].data());
    }
    built.unknowns.push_back(chain.nodes.back().data());
  }
  built.blocks.push_back(
      built.problem->AddResidualBlock(prior_cost(settings).release(), nullptr, p.data()));
  built.cluster.push_back(cluster + 1);
  // Samples are assigned to windows by the present latencies: these change little in one pass.
  for (const Parameter k :
       {gyro_latency, accel_latency, wheel_latency_front, wheel_latency_rear, steering_delay}) {
    if (!settings.free[k]) continue;
    built.problem->SetParameterLowerBound(p.data(), static_cast<int>(k), p[k] - latency_stride);
    built.problem->SetParameterUpperBound(p.data(), static_cast<int>(k), p[k] + latency_stride);
  }
  std::vector<int> constant;
  for (std::size_t k = 0; k < parameters; ++k)
    if (!settings.free[k]) constant.push_back(static_cast<int>(k));
  if (!constant.empty())
    built.problem->SetManifold(p.data(),
                               new ceres::SubsetManifold(static_cast<int>(parameters), constant));
  return built;
}

// With the Jacobian J at the solution, A = Jᵀ J, and the rows of one cluster together:
//   cov = A⁻¹ (Σ_c s_c s_cᵀ + P) A⁻¹,  s_c = J_cᵀ e_c,  P the priors' part of A,
// of which only the parameters' rows are needed: A⁻¹ E.
void uncertainties(const Built& built, const Settings& settings, Result& result) {
  std::vector<std::size_t> free;
  for (std::size_t k = 0; k < parameters; ++k)
    if (settings.free[k]) free.push_back(k);
  const auto count = static_cast<Eigen::Index>(free.size());

  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = built.unknowns;
  options.residual_blocks = built.blocks;
  options.num_threads = settings.threads;
  ceres::CRSMatrix crs;
  std::vector<double> e;
  double cost = 0.0;
  if (!built.problem->Evaluate(options, &cost, &e, nullptr, &crs))
    throw std::runtime_error("the fit's uncertainty could not be computed");
  const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> jacobian(
      crs.num_rows, crs.num_cols, static_cast<Eigen::Index>(crs.values.size()), crs.rows.data(),
      crs.cols.data(), crs.values.data());
  Eigen::SparseMatrix<double> a =
      (Eigen::SparseMatrix<double>(jacobian.transpose()) * Eigen::SparseMatrix<double>(jacobian));
  for (Eigen::Index k = 0; k < a.rows(); ++k) a.coeffRef(k, k) += 1e-9;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(a);
  if (factor.info() != Eigen::Success)
    throw std::runtime_error("the fit's information is singular: fix some parameters (--fix)");
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(a.rows(), count);
  unit.topRows(count) = Eigen::MatrixXd::Identity(count, count);
  const Eigen::MatrixXd inverse = factor.solve(unit);  // columns of A⁻¹

  const Eigen::MatrixXd naive = inverse.topRows(count);
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const double prior_sigma = settings.known(free[static_cast<std::size_t>(k)]).sigma;
    prior(k, k) = 1.0 / (prior_sigma * prior_sigma);
  }
  Eigen::MatrixXd sandwich = naive * prior * naive;
  Eigen::VectorXd influence = Eigen::VectorXd::Zero(count);
  Eigen::Index row = 0;
  std::size_t cluster = built.cluster.front(), clusters = 0;
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t b = 0; b + 1 < built.blocks.size(); ++b) {
    if (built.cluster[b] != cluster) {
      scatter += influence * influence.transpose();
      influence.setZero();
      cluster = built.cluster[b];
      ++clusters;
    }
    const int rows =
        built.problem->GetCostFunctionForResidualBlock(built.blocks[b])->num_residuals();
    for (int i = 0; i < rows; ++i, ++row)
      for (Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>>::InnerIterator it(
               jacobian, row);
           it; ++it)
        influence +=
            inverse.row(it.col()).transpose() * (it.value() * e[static_cast<std::size_t>(row)]);
  }
  scatter += influence * influence.transpose();
  ++clusters;
  sandwich += scatter *
              (static_cast<double>(clusters) / std::max(1.0, static_cast<double>(clusters) - 1.0));

  result.covariance = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(parameters),
                                            static_cast<Eigen::Index>(parameters));
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t k = free[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < count; ++j)
      result.covariance(static_cast<Eigen::Index>(k),
                        static_cast<Eigen::Index>(free[static_cast<std::size_t>(j)])) =
          i == j ? std::max(sandwich(i, i), naive(i, i)) : sandwich(i, j);
    result.naive[k] = std::sqrt(std::max(naive(i, i), 0.0));
    result.sigma[k] = std::sqrt(std::max(sandwich(i, i), naive(i, i)));
  }
  result.cost = cost;
}

}  // namespace odomd::tools::fitting
