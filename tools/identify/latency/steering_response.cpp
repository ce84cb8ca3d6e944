#include "tools/identify/latency/latency_estimate.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/identify/common/car_model.hpp"
#include "tools/identify/common/time_shift.hpp"
#include "tools/math/least_squares.hpp"

namespace odomd::tools {
namespace {

using Eigen::VectorXd;

// Time constant, stiffnesses, inertia, relaxation, bends, steering scale: logarithms.
enum : Eigen::Index {
  dead,
  lag,
  front,
  rear,
  inertia,
  relaxation,
  bend_front,
  bend_rear,
  steering_scale,
  steering_offset,
  gyro_bias,
  count
};

// Start values: the time constant is 30 ms times exp(lag), the tyres' bend 0.7 times exp(bend).
constexpr double usual_lag = 0.03, usual_bend = 0.7;
constexpr std::array<double, count> prior_sigma{1.0, 1.0, 0.15, 0.15, 0.1, 0.5,
                                                0.5, 0.5, 0.05, 0.1,  0.1};
constexpr double step_s = 5e-3;
constexpr double block_s = 2.0;  // residuals further apart are independent
// Tyre effects beyond this model, as standard uncertainties [s]. The yaw rate hardly shows how dead
// time, time constant and tyres share the lag. Their sum is observable if the tyres slip little.
constexpr double unmodelled_share = 0.012;
constexpr double unmodelled_sum = 0.35e-3, unmodelled_slip = 40e-3, unmodelled_factor = 1.5;
constexpr double slow_lag = 0.05, unmodelled_slow = 0.02;  // [s]; [s] per second beyond slow_lag

struct DrivenCar {
  const estimator::Vehicle& car;
  const Resampled& steering;
  const Resampled& speed;
  std::vector<double> t;  ///< of the gyro [s]
  VectorXd yaw_rate;
};

VectorXd predicted(const DrivenCar& drive, const VectorXd& p, FrontWheels* seen = nullptr) {
  namespace model = car_model;
  const estimator::Vehicle& v = drive.car;
  model::Car<double> car{.mass = v.mass,
                         .front_axle = v.front_axle,
                         .rear_axle = v.rear_axle,
                         .inertia = v.yaw_inertia * std::exp(p[inertia]),
                         .stiffness_front = v.cornering_stiffness_front * std::exp(p[front]),
                         .stiffness_rear = v.cornering_stiffness_rear * std::exp(p[rear]),
                         .bend_front = usual_bend * std::exp(p[bend_front]),
                         .bend_rear = usual_bend * std::exp(p[bend_rear]),
                         .relaxation = 0.17 * v.wheelbase() * std::exp(p[relaxation]),
                         .load_arm = 0.14 * v.wheelbase(),
                         .lag = usual_lag * std::exp(p[lag]),
                         .track = v.track_width};
  car.floor_speed = model::floor_speed(v.mass, v.front_axle, v.rear_axle, car.inertia,
                                       car.stiffness_front, car.stiffness_rear, step_s);
  const auto wanted = [&](double t) {
    return std::exp(p[steering_scale]) * drive.steering.at(t - p[dead]) - p[steering_offset];
  };
  model::State<double> x{};
  double t = drive.speed.begin;
  x[model::steer] = wanted(t);
  double before = x[model::yaw_rate];
  VectorXd result(static_cast<Eigen::Index>(drive.t.size()));
  const double end = drive.speed.end();
  std::size_t next = 0;
  while (next < drive.t.size()) {
    if (t >= end) {
      result[static_cast<Eigen::Index>(next++)] = x[model::yaw_rate] + p[gyro_bias];
      continue;
    }
    x[model::v_x] = drive.speed.at(t);
    const double accel = (drive.speed.at(t + step_s) - x[model::v_x]) / step_s;
    before = x[model::yaw_rate];
    if (seen != nullptr) {
      seen->angle.value.push_back(x[model::steer]);
      seen->side_speed.value.push_back(x[model::v_y]);
    }
    x = model::step(car, x, wanted(t + 0.5 * step_s), accel, accel, step_s);
    for (; next < drive.t.size() && drive.t[next] <= t + step_s; ++next) {
      const double part = std::clamp((drive.t[next] - t) / step_s, 0.0, 1.0);
      result[static_cast<Eigen::Index>(next)] =
          before + part * (x[model::yaw_rate] - before) + p[gyro_bias];
    }
    t += step_s;
  }
  return result;
}

double spread_of(const VectorXd& z) {
  return std::sqrt((z.array() - z.mean()).square().mean());
}

// Uses only the drive's beginning, until the yaw rate has varied about as in the whole drive.
double rough_dead_time(const LeastSquares& problem, const DrivenCar& drive) {
  const double whole = spread_of(drive.yaw_rate);
  const Eigen::Index all = drive.yaw_rate.size();
  Eigen::Index head = std::min<Eigen::Index>(1000, all);
  while (head < all && spread_of(drive.yaw_rate.head(head)) < std::sqrt(0.5) * whole)
    head = std::min(2 * head, all);
  DrivenCar begin = drive;
  begin.t.resize(static_cast<std::size_t>(head));
  begin.yaw_rate.conservativeResize(head);
  LeastSquares rough = problem;
  rough.residuals = [&begin](const VectorXd& p) -> VectorXd {
    return begin.yaw_rate - predicted(begin, p);
  };
  std::vector<double> trials;
  for (double trial = -0.3; trial <= 0.6; trial += 0.02) trials.push_back(trial);
  return best_of(rough, dead, trials, std::max(0.2 * spread_of(begin.yaw_rate), 1e-9));
}

}  // namespace

SteeringResponse steering_response(const estimator::Vehicle& car, const Resampled& steering,
                                   const Resampled& speed, const Series& gyro,
                                   std::int64_t origin_ns, const ReportProgress& report) {
  SteeringResponse result;
  DrivenCar drive{car, steering, speed, {}, {}};
  std::vector<double> yaw_rate;
  const std::size_t every = std::max<std::size_t>(1, gyro.size() / 12000);
  for (std::size_t i = 0; i < gyro.size(); i += every) {
    drive.t.push_back(1e-9 * static_cast<double>(gyro.t_ns[i] - origin_ns));
    yaw_rate.push_back(gyro.value[i]);
  }
  drive.yaw_rate = Eigen::Map<const VectorXd>(yaw_rate.data(), std::ssize(yaw_rate));
  if (drive.t.size() < 50) {
    result.failure = "too few samples";
    return result;
  }
  const double spread = spread_of(drive.yaw_rate);
  if (!(spread > 0.02)) {
    result.failure = "the car does not turn";
    return result;
  }
  int simulated = 0;
  LeastSquares problem;
  problem.residuals = [&](const VectorXd& p) -> VectorXd {
    ++simulated;
    if (report)
      report(fmt::format("steering: simulation {} of the drive; usually 100 to 800 are needed",
                         simulated));
    return drive.yaw_rate - predicted(drive, p);
  };
  problem.prior_sigma = Eigen::Map<const VectorXd>(prior_sigma.data(), count);
  problem.step = 1e-3 * problem.prior_sigma.cwiseMax(1e-2);
  problem.start = problem.expected = VectorXd::Zero(count);
  problem.start[dead] = rough_dead_time(problem, drive);
  // At constant speed only the prior of the tyres separates their relaxation from the lag; small
  // model errors must not. So a block counts as one sample.
  problem.together = std::max(1.0, block_s * static_cast<double>(drive.t.size()) /
                                       std::max(drive.t.back() - drive.t.front(), block_s));
  const LeastSquaresSolution found = solve(problem);
  const Eigen::MatrixXd covariance =
      covariance_by_blocks(problem, found, blocks_of(drive.t, block_s));
  const double tau = usual_lag * std::exp(found.parameters[lag]);  // and dτ = τ dp
  const double of_dead = covariance(dead, dead), of_tau = tau * tau * covariance(lag, lag);
  const double of_all = std::max(of_dead + of_tau + 2.0 * tau * covariance(dead, lag), 0.0);
  result.dead_time = {found.parameters[dead], std::hypot(std::sqrt(of_dead), unmodelled_share)};
  result.time_constant = {tau, std::hypot(std::sqrt(of_tau), unmodelled_share)};
  // The tyres' effect on the sum grows with the square of the lateral force.
  double force = 0.0;
  for (std::size_t i = 0; i < drive.t.size(); ++i)
    force += std::pow(speed.at(drive.t[i]) * yaw_rate[i] / car_model::gravity, 2);
  const double slow = std::max(found.parameters[dead] + tau - slow_lag, 0.0);
  const double unmodelled = unmodelled_sum +
                            unmodelled_slip * force / static_cast<double>(drive.t.size()) +
                            unmodelled_slow * slow;
  result.in_all = {found.parameters[dead] + tau,
                   std::hypot(unmodelled_factor * std::sqrt(of_all), unmodelled)};
  result.explained = std::max(0.0, 1.0 - std::pow(found.noise / spread, 2));
  result.front_wheels.angle = result.front_wheels.side_speed = {drive.speed.begin, step_s, {}};
  (void)predicted(drive, found.parameters, &result.front_wheels);
  if (result.explained < 0.5)
    result.failure = "the yaw rate does not follow the steering: sign, scale, mapping?";
  return result;
}

// The part of the response that goes into [steering].
namespace {

constexpr double chance = 3.0;  // standard uncertainties that chance explains
// Sigmas required of a determined value: a tenth of the total, clamped to 10 to 20 ms, for the
// total; a quarter of the total for delay and lag.
constexpr double known_at_least = 0.01, known_at_most = 0.02, known_share = 0.1,
                 separable_below = 0.25;
constexpr double longest_delay = 0.5, longest_lag = 1.0;  // limits of the configuration [s]

std::string milliseconds(const Measured& time) {
  return fixed(1e3 * time.value, 0) + " +- " + fixed(1e3 * time.sigma, 0) + " ms";
}

/// Why delay and lag are not determined; empty if they are.
std::string reason_undetermined(const SteeringResponse& response, const Measured& whole,
                                const Measured& delay) {
  const Measured& time_constant = response.time_constant;
  if (!response.failure.empty()) return response.failure;
  if (!(whole.sigma < std::clamp(known_share * whole.value, known_at_least, known_at_most)))
    return milliseconds(whole) + " in total; drive with more turns and changes of speed";
  if (whole.value < chance * whole.sigma)
    return "none visible, " + milliseconds(whole) +
           " in total: as expected if the angle is measured";
  if (!(std::max(delay.sigma, time_constant.sigma) < separable_below * whole.value))
    return "cannot be separated; delay and lag together " + milliseconds(whole);
  if (delay.value > longest_delay || time_constant.value > longest_lag)
    return milliseconds(whole) +
           " in total, more than [steering] allows: is it the car's steering?";
  return "";
}

}  // namespace

void add_actuator(const SteeringResponse& response, const Measured& clock,
                  const estimator::SteeringActuator& configured, Findings& findings) {
  const auto by_clock = [&clock](const Measured& time) {
    return Measured{time.value - clock.value, std::hypot(time.sigma, clock.sigma)};
  };
  const Measured whole = by_clock(response.in_all);
  const Measured delay = by_clock(response.dead_time);
  const std::string failure = reason_undetermined(response, whole, delay);
  const auto add = [&](const char* name, const char* key, const Measured& time) {
    Finding& finding = findings.add(name, failure.empty() ? key : "", time, "s");
    finding.share = Share::meaningless;
    raise_to_zero(finding);
    if (!failure.empty()) finding.reject(failure);
  };
  add("... of this delay", "steering.delay", delay);
  add("... and lag", "steering.lag", response.time_constant);
  const double expected = configured.delay_s + configured.lag_s;
  if (!failure.empty() && response.failure.empty() && expected > 0.0 &&
      std::abs(whole.value - expected) > chance * whole.sigma)
    add_warning(findings.warnings, diagnostics::kind("actuator_not_seen"), "[steering]",
                "has {} ms of delay and lag, the drive shows {}", fixed(1e3 * expected, 0),
                milliseconds(whole));
}

}  // namespace odomd::tools
