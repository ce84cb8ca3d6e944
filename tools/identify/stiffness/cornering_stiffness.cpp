#include "tools/identify/stiffness/cornering_stiffness.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tools/cli/text.hpp"
#include "tools/identify/common/car_model.hpp"
#include "tools/math/least_squares.hpp"

namespace odomd::tools {
namespace {

using car_model::gravity;

// Model error relative to each stiffness: effects of four wheels that the single-track model leaves
// out (the two angles of the front wheels, load transfer, drive forces, different resistance left
// and right), and the shape of the curve.
constexpr double sigma_model = 0.01;

// A circle whose slip exceeds the linear slip by this factor is left out: there the shape of the
// curve would weigh more than its slope.
constexpr double max_slip_factor = 1.25;

enum Unknown : Eigen::Index {
  log_stiffness_front,  // ln C
  log_stiffness_rear,
  log_grip_front,  // ln μ
  log_grip_rear,
  steering_offset,
  steering_scale,
  marker_angle,
  centre_shift,  // distance of the centre of gravity ahead of where the markers place it [m]
  mass,
  front_axle,
  rear_axle,
  rolling_resistance,
  film_scale,
  unknown_count
};
using Unknowns = Eigen::Matrix<double, unknown_count, 1>;

struct Prior {
  Unknowns mean = Unknowns::Zero();
  Unknowns sigma = Unknowns::Ones();
};

Prior prior_of(const CircleCar& car) {
  Prior prior;
  const auto set = [&prior](Unknown which, double mean, double sigma) {
    prior.mean[which] = mean;
    prior.sigma[which] = sigma;
  };
  // A typical axle would carry its load as side force at 1/6 rad. The prior is wide so that it does
  // not affect the result.
  const double load = car.mass.value * gravity / car.wheelbase();
  set(log_stiffness_front, std::log(6.0 * load * car.rear_axle.value), 5.0);
  set(log_stiffness_rear, std::log(6.0 * load * car.front_axle.value), 5.0);
  set(log_grip_front, 0.0, 0.7);  // μ of 0.5 to 2, at one sigma
  set(log_grip_rear, 0.0, 0.7);
  set(steering_offset, 0.0, 0.1);
  set(steering_scale, 1.0, 0.1);
  set(marker_angle, 0.0, std::numbers::sqrt2 * car.sigma_marker / car.marker_distance);
  set(centre_shift, 0.0, car.sigma_marker);
  set(mass, car.mass.value, car.mass.sigma);
  set(front_axle, car.front_axle.value, car.front_axle.sigma);
  set(rear_axle, car.rear_axle.value, car.rear_axle.sigma);
  set(rolling_resistance, car.rolling_resistance.value, car.rolling_resistance.sigma);
  set(film_scale, 1.0, car.sigma_scale);
  prior.sigma = prior.sigma.cwiseMax(1e-9);
  return prior;
}

// atanh(u) / u as a function of u², continued as a straight line near u = 1.
double slip_factor(double u_squared) {
  constexpr double end = 0.9;
  if (u_squared > end) {
    const double u = std::sqrt(end);
    const double value = std::atanh(u) / u;
    return value + (1.0 / (1.0 - end) - value) / (2.0 * end) * (u_squared - end);
  }
  if (u_squared < 1e-6) return 1.0 + u_squared / 3.0;
  const double u = std::sqrt(u_squared);
  return std::atanh(u) / u;
}

double slip_of(double force, double stiffness, double grip) {
  return force / stiffness * slip_factor(force * force / (grip * grip));
}

// An axle on a circle, for assumed values of the unknowns, with the characteristic of its tyres.
struct AxleView {
  double slip = 0.0;  // measured
  double force = 0.0;
  double stiffness = 0.0, grip = 0.0;

  [[nodiscard]] double residual() const { return slip - slip_of(force, stiffness, grip); }
  [[nodiscard]] bool is_beyond_range() const {
    const double u = force / grip;
    return slip_factor(u * u) > max_slip_factor;
  }
};

// Front and rear axle.
std::array<AxleView, 2> view(const CircleRun& run, const Unknowns& x) {
  const double drift = run.drift.value - x[marker_angle];
  const double speed = x[film_scale] * run.speed;
  const double v_x = speed * std::cos(drift);
  const double v_y = speed * std::sin(drift) + x[centre_shift] * run.yaw_rate;
  const double steering = (run.steering.value - x[steering_offset]) / x[steering_scale];
  const double wheelbase = x[front_axle] + x[rear_axle];
  const double load_front = x[mass] * gravity * x[rear_axle] / wheelbase;
  const double load_rear = x[mass] * gravity * x[front_axle] / wheelbase;
  const double side = x[mass] * x[film_scale] * run.lateral_accel / wheelbase;
  const double rolling = x[rolling_resistance] * load_front * std::sin(steering);
  return {AxleView{.slip = steering - std::atan2(v_y + x[front_axle] * run.yaw_rate, v_x),
                   .force = (x[rear_axle] * side + rolling) / std::cos(steering),
                   .stiffness = std::exp(x[log_stiffness_front]),
                   .grip = std::exp(x[log_grip_front]) * load_front},
          AxleView{.slip = -std::atan2(v_y - x[rear_axle] * run.yaw_rate, v_x),
                   .force = x[front_axle] * side,
                   .stiffness = std::exp(x[log_stiffness_rear]),
                   .grip = std::exp(x[log_grip_rear]) * load_rear}};
}

// Scatter of the measured slip: front axle, rear axle.
std::array<double, 2> slip_sigmas(const CircleRun& run) {
  return {std::hypot(run.drift.sigma, run.steering.sigma), run.drift.sigma};
}

// Measured minus fitted slip: front and rear axle for each circle.
Eigen::VectorXd residuals(std::span<const CircleRun> runs, const Unknowns& x) {
  Eigen::VectorXd r(static_cast<Eigen::Index>(2 * runs.size()));
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const auto [front, rear] = view(runs[k], x);
    r.segment<2>(static_cast<Eigen::Index>(2 * k)) << front.residual(), rear.residual();
  }
  return r;
}

struct Solution {
  Unknowns x;
  Eigen::MatrixXd covariance;
  Eigen::VectorXd weights;  // one per measured slip
  double scatter = 1.0;     // ratio of the circles' scatter to their own sigmas
};

// If circles scatter more than their sigmas, all sigmas are multiplied by one factor.
Solution fit(std::span<const CircleRun> runs, const Prior& prior) {
  constexpr double huber = 2.0;
  Eigen::VectorXd own(static_cast<Eigen::Index>(2 * runs.size()));
  for (std::size_t k = 0; k < runs.size(); ++k)
    own.segment<2>(static_cast<Eigen::Index>(2 * k)) = Eigen::Vector2d(slip_sigmas(runs[k]).data());
  Solution solution;
  for (int round = 0; round < 4; ++round) {
    LeastSquares problem{.step = 1e-6 * prior.sigma.cwiseMin(0.1),
                         .start = prior.mean,
                         .expected = prior.mean,
                         .prior_sigma = prior.sigma,
                         .noise = 1.0,
                         .huber = no_huber,
                         .enough = 1e-12,
                         .iterations = 60};
    problem.residuals = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      return residuals(runs, x).cwiseQuotient(solution.scatter * own);
    };
    // Outliers are only visible after a first fit.
    problem.start = solve(problem).parameters;
    problem.huber = huber;
    const LeastSquaresSolution found = solve(problem);
    solution.x = found.parameters;
    solution.covariance = found.inverse;
    solution.weights = found.weights;
    // tr(I - hat matrix); Huber's second proposal: an outlier counts with its weight.
    const double freedom = found.weights.sum() - found.from_data.cwiseProduct(found.inverse).sum();
    if (freedom < 1.0) break;
    const double factor =
        std::sqrt(found.weights.cwiseProduct(found.residuals).squaredNorm() / freedom);
    const double scatter = std::max(1.0, solution.scatter * factor);
    if (std::abs(scatter / solution.scatter - 1.0) < 0.02) break;
    solution.scatter = scatter;
  }
  return solution;
}

Measured measured(const Solution& s, Unknown which) {
  return {s.x[which], std::sqrt(s.covariance(which, which))};
}

// C = exp(ln C): σ_C = C σ
Measured stiffness_of(const Solution& s, Unknown which) {
  const Measured logarithm = measured(s, which);
  const double value = std::exp(logarithm.value);
  return {value, value * std::hypot(logarithm.sigma, sigma_model)};
}

}  // namespace

double AxleStiffness::linear_range() const {
  // α C / F = 1 / 0.9 for this atanh(u) / u
  double u = 0.5;
  for (int k = 0; k < 60; ++k) u += 0.5 * (1.0 / 0.9 - slip_factor(u * u));
  return slip_of(u * grip, stiffness.value, grip);
}

double AxleStiffness::force(double slip) const {
  return grip * std::tanh(stiffness.value * slip / grip);
}

CorneringStiffness fit_stiffness(std::span<const CircleRun> runs, const CircleCar& car) {
  if (runs.empty())
    refuse(
        "no steady circle in any film: hold steering and speed for half a turn or more, and film "
        "it whole");
  const Prior prior = prior_of(car);
  CorneringStiffness result;
  result.in_range.assign(runs.size(), true);
  std::vector<CircleRun> used(runs.begin(), runs.end());
  Solution s;
  for (int round = 0; round < 3; ++round) {
    s = fit(used, prior);
    std::vector<bool> in_range(runs.size());
    for (std::size_t k = 0; k < runs.size(); ++k)
      in_range[k] = std::ranges::none_of(view(runs[k], s.x), &AxleView::is_beyond_range);
    if (in_range == result.in_range || std::ranges::count(in_range, true) < 2) break;
    result.in_range = in_range;
    used.clear();
    for (std::size_t k = 0; k < runs.size(); ++k)
      if (in_range[k]) used.push_back(runs[k]);
  }

  Prior free = prior;
  free.sigma[centre_shift] = car.wheelbase();
  free.sigma[marker_angle] = free.sigma[steering_scale] = 1.0;
  const Solution without_priors = fit(used, free);
  result.centre_ahead = measured(without_priors, centre_shift);
  result.free_steering_scale = measured(without_priors, steering_scale);

  result.scatter = s.scatter;
  const auto [front, rear] = view(runs.front(), s.x);
  result.front = {.stiffness = stiffness_of(s, log_stiffness_front), .grip = front.grip};
  result.rear = {.stiffness = stiffness_of(s, log_stiffness_rear), .grip = rear.grip};
  result.steering_offset = measured(s, steering_offset);
  result.steering_scale = measured(s, steering_scale);
  result.marker_angle = measured(s, marker_angle);
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const std::array axles{&result.front, &result.rear};
    for (std::size_t i = 0; i < axles.size(); ++i) {
      const AxleView axle = view(runs[k], s.x)[i];
      axles[i]->points.push_back({.slip = axle.slip,
                                  .force = axle.force,
                                  .sigma = s.scatter * slip_sigmas(runs[k])[i],
                                  .weight = result.in_range[k] ? s.weights[row++] : 0.0});
    }
    if (result.is_used(k)) ++result.used;
  }
  return result;
}

}  // namespace odomd::tools
