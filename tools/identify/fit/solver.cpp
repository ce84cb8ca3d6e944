#include "tools/identify/fit/solver.hpp"

#include <ceres/ceres.h>
#include <ceres/crs_matrix.h>
#include <ceres/dynamic_autodiff_cost_function.h>
#include <ceres/normal_prior.h>
#include <ceres/problem.h>
#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tools/cli/text.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools::fitting {
namespace {

namespace st = car_model;

constexpr double latency_stride = 0.03;  // largest change of a latency in a pass [s]
constexpr double independent_s = 4.0;    // residuals further apart are independent
constexpr double huber = 2.5;            // in standard deviations

/// Standard deviation of the acceleration's change from knot to knot [m/s²].
constexpr double knot_change = 0.7;

/// Standard deviations of the gap between a window's end and the start of the next.
std::array<double, st::states> gap_sigmas(double wheelbase) {
  const double pace = std::sqrt(wheelbase / 0.26);  // for speeds and times (Froude number)
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

/// Residual e such that e² is Huber's loss.
template <class T>
T huber_residual(const T& e) {
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

/// Blocks: the free parameters, a window's first node, its inner unknowns, the next window's node.
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
                      [&](std::size_t kind, const T& e, double stated) {
                        const double noise = setup.noise[kind];
                        *out++ = huber_residual(static_cast<T>(e / (noise > 0.0 ? noise : stated)));
                      });
    for (std::size_t k = 0; k < course.last; ++k)
      *out++ = (course.accel(k + 1) - course.accel(k)) / knot_change;
    for (std::size_t k = 0; k <= course.last; ++k) *out++ = course.steering(k);
    const auto sigma = gap_sigmas(setup.wheelbase);
    for (std::size_t k = 0; k < st::states; ++k)
      *out++ = (trajectory.states.back()[k] - blocks[3][k]) / sigma[k];
    return std::all_of(residuals, out, [](const T& e) { return is_finite(e); });
  }
};

/// The fit as a Ceres problem.
struct Built {
  std::unique_ptr<ceres::Problem> problem;
  std::vector<double> p;          ///< the free parameters, the first of the problem's blocks
  std::vector<int> cluster_rows;  ///< residuals per cluster (windows that count as one), in order
};

/// The result holds references to the setup and the chains.
Built build(const Setup& setup, const Settings& settings, const Numbers<double>& p,
            std::vector<Chain>& chains) {
  const std::vector<std::size_t> free = settings.free_parameters();
  const auto count = static_cast<Eigen::Index>(free.size());
  Built built{.problem = std::make_unique<ceres::Problem>(), .p = {}, .cluster_rows = {}};
  for (const std::size_t k : free) built.p.push_back(p[k]);
  const auto windows_per_cluster =
      std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(independent_s / setup.window)));
  // 72 derivatives: one pass for a usual window (30 free parameters, 10 knots).
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
      if (w % windows_per_cluster == 0) built.cluster_rows.push_back(0);
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
  // Samples are assigned to windows with the present latencies, so these change little per pass.
  for (std::size_t i = 0; i < free.size(); ++i)
    if (parameter_table()[free[i]].unit == "s" &&
        parameter_table()[free[i]].kind == ParameterKind::shift) {
      built.problem->SetParameterLowerBound(built.p.data(), static_cast<int>(i),
                                            built.p[i] - latency_stride);
      built.problem->SetParameterUpperBound(built.p.data(), static_cast<int>(i),
                                            built.p[i] + latency_stride);
    }
  return built;
}

// With the Jacobian J at the solution, A = Jᵀ J, and the rows of each cluster combined:
//   cov = A⁻¹ (Σ_c s_c s_cᵀ + P) A⁻¹,  s_c = J_cᵀ e_c,  P the priors' part of A.
// Only the parameters' rows are needed: A⁻¹ E.
void uncertainties(const Built& built, const Settings& settings, Result& result) {
  const std::vector<std::size_t> free = settings.free_parameters();
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

constexpr int max_passes = 6;             // unless it converges sooner
constexpr int iterations_of_a_pass = 15;  // at most
/// Iterations for a drive with much excitation; others take up to five times as many.
constexpr int usual_iterations = 30;

class ProgressReport final : public ceres::IterationCallback {
 public:
  explicit ProgressReport(const Settings& settings) : settings_(settings) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    pass_ += summary.iteration == 0 ? 1 : 0;
    ++iterations_;
    const double gone =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    const double left = gone / iterations_ * std::max(usual_iterations - iterations_, 5);
    if (settings_.progress)
      settings_.progress(fmt::format(
          "pass {} of {} ({} at most), iteration {}: cost {}, {} s elapsed, about {} s to go",
          pass_, std::max(pass_, settings_.passes), max_passes, summary.iteration,
          fixed(summary.cost, 1), fixed(gone, 0), fixed(left, 0)));
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const Settings& settings_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  int pass_ = 0;
  int iterations_ = 0;
};

constexpr double small_gain = 2e-3;  // relative decrease of the cost in a pass
constexpr double max_latency_change =
    3e-3;  // change of latencies between passes, for a 1:10 car [s]

double latency_change(const Numbers<double>& before, const Numbers<double>& after) {
  double largest = 0.0;
  for (const Parameter k : {gyro_latency, accel_latency, wheel_latency_front, wheel_latency_rear})
    largest = std::max(largest, std::fabs(after[k] - before[k]));
  return largest;
}

}  // namespace

Result solve(const daemon::Config& config, std::span<const FitDrive> drives,
             const Settings& settings) {
  const estimator::Vehicle& car = config.vehicle;
  Setup setup;
  setup.config = &config;
  setup.nominal = nominal_values(config);
  setup.wheelbase = car.wheelbase();
  setup.one_imu = one_imu(config);
  const double fine = setup.step * slowness(config);
  setup.knot *= slowness(config);
  // With knots finer than the sensors' cycles, the motion between two samples would be arbitrary.
  for (const FitDrive& drive : drives)
    setup.knot = std::max(setup.knot, 0.05 * std::ceil(drive.steering_cycle / 0.05 - 0.1));
  setup.window = setup.knot * std::max(2.0, std::round(settings.window / setup.knot));
  // Speeds, like times, scale with the square root of the car's size (Froude number).
  setup.floor_speed = 0.04 * std::sqrt(setup.wheelbase);
  setup.slow = 0.6 * std::sqrt(setup.wheelbase);
  std::vector<Chain> chains;
  for (const FitDrive& drive : drives) {
    std::vector<Chain> parts = chains_of(setup, drive);
    if (parts.empty())
      refuse("{}: nowhere faster than {} m/s for {} s: nothing can be determined", drive.name,
             fixed(setup.slow, 2), fixed(2.0 * setup.window, 1));
    std::ranges::move(parts, std::back_inserter(chains));
  }

  const std::vector<std::size_t> free = settings.free_parameters();
  if (free.empty()) refuse("--fix: no parameter is left to fit");
  Result result;
  ProgressReport progress(settings);
  for (int pass = 1; !result.settled && pass <= max_passes; ++pass) {
    const Numbers<double> before = result.p;
    // Coarse steps suffice far from the solution, if a window contains a whole number of them.
    setup.step = pass == 1 && setup.knots() % 2 == 0 ? 2.0 * fine : fine;
    for (Chain& chain : chains) assign_samples(result.p, setup, chain);
    Built built = build(setup, settings, result.p, chains);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    options.max_num_iterations = iterations_of_a_pass;
    options.function_tolerance = pass >= settings.passes ? 1e-5 : 1e-4;
    options.num_threads = settings.threads;
    options.logging_type = ceres::SILENT;
    options.initial_trust_region_radius = pass == 1 ? 10.0 : 1e4;
    options.callbacks.push_back(&progress);
    // Elimination order: the windows' inner unknowns, the nodes along the chain, the parameters.
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    ordering->AddElementToGroup(built.p.data(), 2);
    for (Chain& chain : chains) {
      for (Node<double>& node : chain.nodes) ordering->AddElementToGroup(node.data(), 1);
      for (std::vector<double>& inner : chain.inner) ordering->AddElementToGroup(inner.data(), 0);
    }
    options.linear_solver_ordering = std::move(ordering);
    ceres::Solver::Summary summary;
    ceres::Solve(options, built.problem.get(), &summary);
    for (std::size_t i = 0; i < free.size(); ++i) result.p[free[i]] = built.p[i];
    result.iterations += static_cast<int>(summary.iterations.size());
    if (!summary.IsSolutionUsable())
      throw std::runtime_error("the fit does not converge: " + summary.message);
    // The next pass assigns samples with the fitted latencies, with noise from the residuals.
    const double gained = summary.initial_cost - summary.final_cost;
    result.settled = pass >= settings.passes && gained < small_gain * summary.final_cost &&
                     latency_change(before, result.p) < max_latency_change * slowness(config);
    if (result.settled || pass == max_passes) {
      uncertainties(built, settings, result);
    } else if (pass <= settings.passes) {  // later the noise stays fixed, so that the fit converges
      update_noise(setup, residuals_of(setup, chains, result.p));
    }
  }

  result.turns = turns_of(chains);
  const Residuals rest = residuals_of(setup, chains, result.p);
  for (std::size_t kind = 0; kind < kinds; ++kind)
    result.sources.push_back({kind == position_kind ? "position"
                              : kind == yaw_kind    ? "yaw"
                                                    : std::string(estimator::source_names[kind]),
                              rest.values[kind].size(), rest.stated[kind],
                              robust_sigma(rest.values[kind])});
  return result;
}

}  // namespace odomd::tools::fitting
