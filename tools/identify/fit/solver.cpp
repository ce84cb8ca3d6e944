#include "tools/identify/fit/solver.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <utility>

#include "tools/cli/text.hpp"
#include "tools/identify/fit/problem.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools::fitting {
namespace {

std::string name_of_kind(std::size_t kind) {
  if (kind == position_kind) return "position";
  if (kind == yaw_kind) return "yaw";
  return std::string(estimator::source_names[kind]);
}

constexpr int most_passes = 6;            // unless it converges sooner
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
      settings_.progress("pass " + std::to_string(pass_) + " of " +
                         std::to_string(std::max(pass_, settings_.passes)) + " (" +
                         std::to_string(most_passes) + " at most), iteration " +
                         std::to_string(summary.iteration) + ": cost " + fixed(summary.cost, 1) +
                         ", " + fixed(gone, 0) + " s elapsed, about " + fixed(left, 0) +
                         " s to go");
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const Settings& settings_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  int pass_ = 0;
  int iterations_ = 0;
};

constexpr double small_gain = 2e-3;  // of the cost, in a pass
constexpr double still = 3e-3;       // of latencies, from pass to pass; of a 1:10 car [s]

double moved(const Numbers<double>& before, const Numbers<double>& after) {
  double most = 0.0;
  for (const Parameter k : {gyro_latency, accel_latency, wheel_latency_front, wheel_latency_rear})
    most = std::max(most, std::fabs(after[k] - before[k]));
  return most;
}

Turns turns_of(const std::vector<Chain>& chains) {
  constexpr double hard = 0.5 * single_track::gravity;
  double bends = 0.0, both = 0.0, pushes = 0.0;
  std::vector<double> accels;
  for (const Chain& chain : chains)
    for (const Node<double>& node : chain.nodes) {
      const double v = node[single_track::v_x], yaw_rate = node[single_track::yaw_rate];
      const double curvature = yaw_rate / v, accel = v * yaw_rate;
      bends += curvature * curvature;
      both += curvature * accel;
      pushes += accel * accel;
      accels.push_back(std::fabs(accel));
    }
  if (!(bends > 0.0) || !(pushes > 0.0)) return {.speed_variety = 1.0};  // nothing turns
  std::ranges::sort(accels);
  const auto beyond = accels.end() - std::ranges::upper_bound(accels, hard);
  return {.speed_variety = std::sqrt(std::max(0.0, 1.0 - both * both / (bends * pushes))),
          .hard = static_cast<double>(beyond) / static_cast<double>(accels.size()),
          .hardest = accels[accels.size() * 19 / 20]};
}

double rounded_window(double wanted, double knot) {
  return knot * std::max(2.0, std::round(wanted / knot));
}

}  // namespace

Result solve(const daemon::Config& config, std::span<const Drive> drives,
             const Settings& settings) {
  const estimator::Vehicle& car = config.vehicle;
  Setup setup;
  setup.config = &config;
  setup.nominal = nominal_values(config);
  setup.wheelbase = car.wheelbase();
  setup.one_imu = one_imu(config);
  const double fine = setup.step * slowness(config);
  setup.knot *= slowness(config);
  // With finer knots than the sensors, the motion between two samples would be arbitrary.
  for (const Drive& drive : drives)
    setup.knot = std::max(setup.knot, 0.05 * std::ceil(drive.steering_cycle / 0.05 - 0.1));
  setup.window = rounded_window(settings.window, setup.knot);
  // Times scale with the car's size by Froude's number.
  setup.floor_speed = 0.04 * std::sqrt(setup.wheelbase);
  setup.slow = 0.6 * std::sqrt(setup.wheelbase);
  std::vector<Chain> chains;
  for (std::size_t k = 0; k < drives.size(); ++k) {
    std::vector<Chain> parts = chains_of(setup, drives[k], k);
    if (parts.empty())
      throw std::invalid_argument(drives[k].name + ": nowhere faster than " + fixed(setup.slow, 2) +
                                  " m/s for " + fixed(2.0 * setup.window, 1) +
                                  " s: nothing can be determined");
    std::ranges::move(parts, std::back_inserter(chains));
  }

  const std::vector<std::size_t> free = settings.free_ones();
  if (free.empty()) throw std::invalid_argument("--fix: no parameter is left to fit");
  Result result;
  ProgressReport progress(settings);
  for (int pass = 1; !result.settled && pass <= most_passes; ++pass) {
    const Numbers<double> before = result.p;
    // Coarse steps suffice far from the solution, if a window holds a whole number of them.
    setup.step = pass == 1 && setup.knots() % 2 == 0 ? 2.0 * fine : fine;
    for (Chain& chain : chains) deal(result.p, setup, chain);
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
    // Elimination order: windows' insides first, then the nodes along the chain, the parameters
    // last.
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
    // Samples are assigned by the fitted latencies, and noise comes from the residuals.
    const double gained = summary.initial_cost - summary.final_cost;
    result.settled = pass >= settings.passes && gained < small_gain * summary.final_cost &&
                     moved(before, result.p) < still * slowness(config);
    if (result.settled || pass == most_passes) {
      uncertainties(built, settings, result);
    } else if (pass <= settings.passes) {  // then they stay fixed, so that it converges
      take_noises(setup, unexplained(setup, chains, result.p));
    }
  }

  result.turns = turns_of(chains);
  Unexplained rest = unexplained(setup, chains, result.p);
  for (std::size_t kind = 0; kind < kinds; ++kind)
    result.sources.push_back({name_of_kind(kind), rest.values[kind].size(), rest.stated[kind],
                              robust_sigma(rest.values[kind])});
  result.residuals = std::move(rest.points);
  return result;
}

}  // namespace odomd::tools::fitting
