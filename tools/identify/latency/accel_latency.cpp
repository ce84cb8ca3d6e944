// Latencies of accelerations.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/identify/latency/source_offsets.hpp"
#include "tools/identify/latency/time_shift.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

// Effect of nonlinear tyres, which the model of the side force leaves out [s], from simulated cars.
constexpr double unmodelled_side_force = 5e-3;

double smoothing(const Series& series) {
  return std::max(two_cycles(series), 0.025);
}

OffsetRegression smoothed(const GyroDrive& drive, const Series& accel) {
  OffsetRegression r;
  const Resampled mean = smooth(drive.on_grid(accel), smoothing(accel));
  for (const std::int64_t t_ns : accel.t_ns) {
    const double t = drive.log.seconds(t_ns);
    if (t < drive.begin + r.range || t > drive.end - r.range) continue;
    r.t.push_back(t);
    r.y.push_back(mean.at(t));
  }
  return r;
}

Resampled slope(const Resampled& signal) {
  return slope_around(signal, 2e-3);
}

double rms_of(const Resampled& signal) {
  double sum = 0.0;
  for (const double value : signal.value) sum += value * value;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(signal.value.size(), 1)));
}

// The side force of a car that turns as measured by the gyro: inertia and the rear axle's slip,
// with relaxation length σ, give the tyre forces,
//   α̇_h = (l_h ψ̇ - v_y - v α_h) / σ,  m a_y = (l C_h α_h + J_z ψ̈) / l_v,  v̇_y = a_y - v ψ̇
// and the sensor is at (p_x, p_y): a_y + ψ̈ p_x - ψ̇² p_y.
enum : Eigen::Index { late, stiffness, inertia, relaxation, lever_x, lever_y, gain, bias, numbers };

struct Turning {
  const daemon::Config& config;
  Resampled speed, yaw_rate, yaw_accel;
  std::vector<double> t;
};

Eigen::VectorXd side_force(const Turning& turning, const Eigen::VectorXd& p) {
  const estimator::Vehicle& car = turning.config.vehicle;
  const double stiff = car.cornering_stiffness_rear * std::exp(p[stiffness]);
  const double moment = car.yaw_inertia * std::exp(p[inertia]);
  const double sigma = 0.17 * car.wheelbase() * std::exp(p[relaxation]);
  constexpr double dt = 5e-3;
  double v_y = 0.0, slip = 0.0, before = 0.0, measured = 0.0;
  Eigen::VectorXd result(static_cast<Eigen::Index>(turning.t.size()));
  double t = turning.speed.begin;
  std::size_t next = 0;
  while (next < turning.t.size()) {
    const double v = turning.speed.at(t), r = turning.yaw_rate.at(t);
    const double turn = turning.yaw_accel.at(t);
    const double accel =
        (car.wheelbase() * stiff * slip + moment * turn) / (car.front_axle * car.mass);
    before = measured;
    measured = (1.0 + p[gain]) * (accel + turn * (turning.config.imu_position[0] + p[lever_x]) -
                                  r * r * (turning.config.imu_position[1] + p[lever_y])) +
               p[bias];
    for (; next < turning.t.size() && turning.t[next] - p[late] <= t; ++next) {
      const double part = std::clamp(1.0 - (t - turning.t[next] + p[late]) / dt, 0.0, 1.0);
      result[static_cast<Eigen::Index>(next)] = before + part * (measured - before);
    }
    if (t > turning.speed.end() + 1.0) break;
    // The slip settles within a step where the way is short: implicit in it and in v_y.
    const double rate = dt * std::max(std::fabs(v), 0.05) / sigma;
    slip = (slip + dt * (car.rear_axle * r - v_y) / sigma) /
           (1.0 + rate + dt * dt * car.wheelbase() * stiff / (car.front_axle * car.mass * sigma));
    v_y += dt *
           ((car.wheelbase() * stiff * slip + moment * turn) / (car.front_axle * car.mass) - v * r);
    t += dt;
  }
  for (; next < turning.t.size(); ++next) result[static_cast<Eigen::Index>(next)] = measured;
  return result;
}

}  // namespace

SourceOffset lateral(const GyroDrive& drive, const Speed& speed) {
  const Series& series = drive.log.of(Source::accel_y);
  const OffsetRegression measured = smoothed(drive, series);
  SourceOffset result{
      Source::accel_y, "the gyro, by the side force of the turn", 0.0, 0.0, 0.0, ""};
  if (measured.t.size() < 50) {
    result.failure = "too few samples";
    return result;
  }
  const double half = smoothing(series);
  Turning turning{
      drive.config, smooth(speed.value, half), smooth(drive.yaw_rate, half), {}, measured.t};
  turning.yaw_accel = slope(turning.yaw_rate);
  ResponseFit problem;
  problem.t = measured.t;
  problem.z = Eigen::Map<const Eigen::VectorXd>(measured.y.data(),
                                                static_cast<Eigen::Index>(measured.y.size()));
  problem.predicted = [&turning](const Eigen::VectorXd& p) { return side_force(turning, p); };
  const double wheelbase = drive.config.vehicle.wheelbase();
  problem.expected = Eigen::VectorXd::Zero(numbers);
  problem.prior_sigma = Eigen::VectorXd::Zero(numbers);
  problem.prior_sigma << 1.0, 0.15, 0.1, 0.5, 0.05 * wheelbase, 0.1 * wheelbase, 0.05, 2.0;
  std::vector<double> trials;
  for (double trial = -0.3; trial <= 0.3; trial += 0.02) trials.push_back(trial);
  problem.start = problem.expected;
  problem.start[late] = best_of(problem, late, trials);
  const FittedResponse found = fit(problem);
  result.offset = found.parameters[late];
  result.sigma = std::hypot(std::sqrt(found.covariance(late, late)), unmodelled_side_force);
  result.explained = found.explained;
  if (found.explained < 0.5)
    result.failure = "it does not follow the turns: check sign and mounting, or vibration";
  return result;
}

// a_x = dv/dt - v_y ψ̇ - ψ̇² p_x - ψ̈ p_y + b
SourceOffset longitudinal(const GyroDrive& drive, const Speed& speed) {
  const Series& series = drive.log.of(Source::accel_x);
  OffsetRegression r = smoothed(drive, series);
  const Resampled yaw_rate = smooth(drive.yaw_rate, smoothing(series));
  const Resampled v = smooth(speed.value, smoothing(series));
  const Resampled turn2 = times(yaw_rate, yaw_rate);
  const Resampled wide = times(turn2, times(v, v));
  const Resampled accel = slope(v);
  const estimator::Vehicle& car = drive.config.vehicle;
  const double slip = car.mass * car.front_axle / (car.wheelbase() * car.cornering_stiffness_rear);
  const double scrub = car.mass * car.rear_axle / (car.wheelbase() * car.cornering_stiffness_front);
  r.basis = {{accel, 1.0, 0.05},
             {turn2, 0.0, car.wheelbase()},
             {wide, 0.0, slip + scrub},
             {slope(yaw_rate), -drive.config.imu_position[1], 0.2 * car.wheelbase()},
             {slope(times(v, accel)), 0.0, speed.driven ? 0.02 : 0.001},
             {constant(accel)}};
  const Offset found = solve(r);
  SourceOffset result =
      as_offset(Source::accel_x, speed.driven ? "driven wheels' speed" : "wheels' speed", found);
  result.sigma = std::hypot(result.sigma, speed.offset_sigma);
  // In a turn the tyres also drag, and v_y follows with an unknown delay of some hundredths of a
  // second: terms other than dv/dt may bias the offset.
  const double in_turns = rms_of(combined(turn2, wide, [&](double a, double b) {
    return found.coefficients[1] * a + found.coefficients[2] * b;
  }));
  const double share = in_turns / std::max(std::fabs(found.coefficients[0]) * rms_of(accel), 1e-9);
  result.sigma = std::hypot(result.sigma, 0.03 * share);
  return result;
}

}  // namespace odomd::tools
