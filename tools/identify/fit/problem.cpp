#include "tools/identify/fit/problem.hpp"

#include <ceres/crs_matrix.h>
#include <ceres/dynamic_autodiff_cost_function.h>
#include <ceres/normal_prior.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace odomd::tools::fitting {
namespace {

namespace st = single_track;

constexpr double latency_stride = 0.03;  // in a pass [s]
constexpr double independent_s = 4.0;    // residuals further apart are independent
constexpr double huber = 2.5;            // in standard deviations

/// The acceleration's change from knot to knot, as a standard deviation [m/s²].
constexpr double knot_change = 0.7;

/// Standard deviations of the gap between a window's end and the start of the next.
std::array<double, st::states> believed(double wheelbase) {
  const double pace = std::sqrt(wheelbase / 0.26);  // of speeds, and of times, by Froude's number
  return {0.004 * wheelbase,
          0.004 * wheelbase,
          1e-3,
          4e-3 * pace,
          0.03 * pace,
          0.04 / pace,
          3e-3,
          0.01,
          0.01};
}

/// Residual e so that e² is Huber's loss.
template <class T>
T bounded(const T& e) {
  using std::sqrt;
  if (number(e) > huber) return sqrt(2.0 * huber * e - huber * huber);
  if (number(e) < -huber) return -sqrt(-2.0 * huber * e - huber * huber);
  return e;
}

bool is_finite(double e) {
  return std::isfinite(e);
}
template <class T>
bool is_finite(const T& e) {
  return std::isfinite(e.a) && e.v.allFinite();
}

/// Blocks: the free parameters, a window's first node, what is inside, the next window's node.
struct WindowCost {
  const Setup& setup;
  const Window& window;
  const std::vector<std::size_t> free;

  [[nodiscard]] std::size_t rows() const {
    return window.samples.size() + 3 * window.poses.size() + 2 * setup.knots() + 1 + st::states;
  }

  template <class T>
  bool operator()(T const* const* blocks, T* const residuals) const {
    Numbers<T> p;
    p.fill(static_cast<T>(0.0));
    for (std::size_t k = 0; k < free.size(); ++k) p[free[k]] = blocks[0][k];
    Node<T> node;
    std::copy_n(blocks[1], node_size, node.begin());
    const Course<T> course{blocks[1][st::states], blocks[2], blocks[3][st::states], setup.knots()};
    const Run<T> trajectory = run(setup, window, p, node, course);

    T* out = residuals;
    for_each_residual(setup, window, p, trajectory,
                      [&](std::size_t kind, double /*t*/, const T& e, double stated) {
                        const double noise = setup.noise[kind];
                        *out++ = bounded(static_cast<T>(e / (noise > 0.0 ? noise : stated)));
                      });
    for (std::size_t k = 0; k < course.last; ++k)
      *out++ = (course.accel(k + 1) - course.accel(k)) / knot_change;
    for (std::size_t k = 0; k <= course.last; ++k) *out++ = course.steering(k);
    const auto sigma = believed(setup.wheelbase);
    for (std::size_t k = 0; k < st::states; ++k)
      *out++ = (trajectory.states.back()[k] - blocks[3][k]) / sigma[k];
    return std::all_of(residuals, out, [](const T& e) { return is_finite(e); });
  }
};

}  // namespace

std::vector<std::size_t> Settings::free_ones() const {
  std::vector<std::size_t> ones;
  for (std::size_t k = 0; k < parameters; ++k)
    if (free[k]) ones.push_back(k);
  return ones;
}

Measured Settings::known(std::size_t k) const {
  if (k != gyro_bias || !rest) return {0.0, prior_sigma[k]};
  const double by_rest = 1.0 / (rest->sigma * rest->sigma),
               all = by_rest + 1.0 / (prior_sigma[k] * prior_sigma[k]);
  return {rest->value * by_rest / all, 1.0 / std::sqrt(all)};
}

Built build(const Setup& setup, const Settings& settings, const Numbers<double>& p,
            std::vector<Chain>& chains) {
  const std::vector<std::size_t> free = settings.free_ones();
  const auto count = static_cast<Eigen::Index>(free.size());
  Built built{.problem = std::make_unique<ceres::Problem>(), .p = {}, .cluster_rows = {}};
  for (const std::size_t k : free) built.p.push_back(p[k]);
  const auto together =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(independent_s / setup.window)));
  // One pass for the blocks of a usual window: 30 free parameters, 10 knots.
  using Cost = ceres::DynamicAutoDiffCostFunction<WindowCost, 72>;
  for (Chain& chain : chains) {
    for (std::size_t w = 0; w < chain.windows.size(); ++w) {
      auto functor = std::make_unique<WindowCost>(WindowCost{setup, chain.windows[w], free});
      const auto rows = static_cast<int>(functor->rows());
      auto cost = std::make_unique<Cost>(functor.release());
      for (const std::size_t size : {free.size(), node_size, setup.inner(), node_size})
        cost->AddParameterBlock(static_cast<int>(size));
      cost->SetNumResiduals(rows);
      built.problem->AddResidualBlock(cost.release(), nullptr, built.p.data(),
                                      chain.nodes[w].data(), chain.inner[w].data(),
                                      chain.nodes[w + 1].data());
      if (w % together == 0) built.cluster_rows.push_back(0);
      built.cluster_rows.back() += rows;
    }
  }
  Eigen::MatrixXd precision = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd expected(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Measured known = settings.known(free[static_cast<std::size_t>(i)]);
    precision(i, i) = 1.0 / known.sigma;
    expected(i) = known.value;
  }
  built.problem->AddResidualBlock(new ceres::NormalPrior(precision, expected), nullptr,
                                  built.p.data());
  // Samples are assigned to windows by the present latencies: these change little in one pass.
  for (std::size_t i = 0; i < free.size(); ++i)
    if (parameter_table()[free[i]].unit == "s" && parameter_table()[free[i]].kind == Kind::shift) {
      built.problem->SetParameterLowerBound(built.p.data(), static_cast<int>(i),
                                            built.p[i] - latency_stride);
      built.problem->SetParameterUpperBound(built.p.data(), static_cast<int>(i),
                                            built.p[i] + latency_stride);
    }
  return built;
}

// With the Jacobian J at the solution, A = Jᵀ J, and the rows of one cluster together:
//   cov = A⁻¹ (Σ_c s_c s_cᵀ + P) A⁻¹,  s_c = J_cᵀ e_c,  P the priors' part of A,
// of which only the parameters' rows are needed: A⁻¹ E.
void uncertainties(const Built& built, const Settings& settings, Result& result) {
  const std::vector<std::size_t> free = settings.free_ones();
  const auto count = static_cast<Eigen::Index>(free.size());
  ceres::Problem::EvaluateOptions options;
  options.num_threads = settings.threads;
  ceres::CRSMatrix crs;
  std::vector<double> residuals;
  if (!built.problem->Evaluate(options, nullptr, &residuals, nullptr, &crs))
    throw std::runtime_error("the fit's uncertainty could not be computed");
  const Eigen::SparseMatrix<double, Eigen::RowMajor> jacobian =
      Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>>(
          crs.num_rows, crs.num_cols, static_cast<Eigen::Index>(crs.values.size()), crs.rows.data(),
          crs.cols.data(), crs.values.data());
  const Eigen::Map<const Eigen::VectorXd> e(residuals.data(), crs.num_rows);
  Eigen::SparseMatrix<double> a = jacobian.transpose() * jacobian;
  for (Eigen::Index k = 0; k < a.rows(); ++k) a.coeffRef(k, k) += 1e-9;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(a);
  if (factor.info() != Eigen::Success)
    throw std::runtime_error("the fit's information is singular: fix some parameters (--fix)");
  const Eigen::MatrixXd inverse =  // columns of A⁻¹
      factor.solve(Eigen::MatrixXd(Eigen::MatrixXd::Identity(a.rows(), count)));
  const Eigen::MatrixXd naive = inverse.topRows(count);

  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(count, count);
  Eigen::Index row = 0;
  for (const int rows : built.cluster_rows) {
    const Eigen::VectorXd influence =
        inverse.transpose() * (jacobian.middleRows(row, rows).transpose() * e.segment(row, rows));
    scatter += influence * influence.transpose();
    row += rows;
  }
  const auto clusters = static_cast<double>(built.cluster_rows.size());
  Eigen::VectorXd prior(count);
  for (Eigen::Index k = 0; k < count; ++k)
    prior(k) = 1.0 / std::pow(settings.known(free[static_cast<std::size_t>(k)]).sigma, 2);
  Eigen::MatrixXd sandwich =
      naive * prior.asDiagonal() * naive + scatter * (clusters / std::max(1.0, clusters - 1.0));
  sandwich.diagonal() = sandwich.diagonal().cwiseMax(naive.diagonal());

  constexpr auto all = static_cast<Eigen::Index>(parameters);
  result.covariance = Eigen::MatrixXd::Zero(all, all);
  result.covariance(free, free) = sandwich;
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    result.naive[free[i]] = std::sqrt(std::max(naive(k, k), 0.0));
    result.sigma[free[i]] = std::sqrt(sandwich(k, k));
  }
}

}  // namespace odomd::tools::fitting
