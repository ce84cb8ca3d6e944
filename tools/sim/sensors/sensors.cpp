#include "tools/sim/sensors/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>

namespace odomd::sim {
namespace {

using enum Parameter;

// Noise as a fraction of its full value: a part at rest, plus vibration that grows linearly with
// speed up to vibration_speed.
double noise_share(const ParameterSet& truth, const PlantOutput& car) {
  const double rest = truth[noise_at_rest];
  return rest + (1.0 - rest) * std::min(1.0, std::abs(car.v_x) / truth[vibration_speed]);
}

// A range of 0 means no limit.
double saturated(double value, double range) {
  return range > 0.0 ? std::clamp(value, -range, range) : value;
}

// A step of 0 means that the value is not quantised.
double quantised(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

}  // namespace

void PastOutputs::add(std::int64_t time_ns, const PlantOutput& output) {
  while (past_.size() > 2 && past_[1].time_ns < past_.back().time_ns - reach_ns_) past_.pop_front();
  past_.push_back({time_ns, output});
}

PlantOutput PastOutputs::at(std::int64_t time_ns) const {
  const auto to = std::ranges::lower_bound(past_, time_ns, {}, &Past::time_ns);
  if (to == past_.begin()) {
    PlantOutput first = to->output;
    for (std::size_t wheel = 0; wheel < wheel_count; ++wheel)
      first.wheel_angle[wheel] += first.wheel_rate[wheel] * seconds(time_ns - to->time_ns);
    return first;
  }
  const auto from = std::prev(to);
  return interpolate(from->output, to->output,
                     seconds(time_ns - from->time_ns) / seconds(to->time_ns - from->time_ns));
}

Imu::Imu(const ParameterSet& truth, std::uint64_t seed)
    : truth_(truth),
      gyro_bias_(truth[gyro_bias], truth[gyro_bias_walk], seed, "walk of the gyro"),
      accel_bias_x_(truth[accel_bias_x], truth[accel_bias_walk], seed, "walk of accel x"),
      accel_bias_y_(truth[accel_bias_y], truth[accel_bias_walk], seed, "walk of accel y"),
      gyro_noise_(seed, "noise of the gyro"),
      accel_noise_(seed, "noise of the accelerometers") {}

ImuReading Imu::read(const PlantOutput& gyro_car, const PlantOutput& car, double dt) {
  const Vector2 force = specific_force_at(car, truth_[imu_x], truth_[imu_y], truth_[imu_z]);
  const double c = std::cos(truth_[imu_yaw_error]), s = std::sin(truth_[imu_yaw_error]);
  const double share = noise_share(truth_, car);
  const double scale = 1.0 + truth_[accel_scale_error];
  // b(t) = b_0 + walk + Δ (1 - e^(-t/τ))
  on_for_ += dt;
  const double drift = -truth_[gyro_drift] * std::expm1(-on_for_ / truth_[gyro_drift_time]);
  const double yaw_rate = (1.0 + truth_[gyro_scale_error]) * body_yaw_rate(gyro_car) +
                          gyro_bias_.after(dt) + drift +
                          share * truth_[gyro_noise] * gyro_noise_.normal();
  const double accel_x = scale * (c * force.x + s * force.y) + accel_bias_x_.after(dt) +
                         share * truth_[accel_noise] * accel_noise_.normal();
  const double accel_y = scale * (-s * force.x + c * force.y) + accel_bias_y_.after(dt) +
                         share * truth_[accel_noise] * accel_noise_.normal();
  return {.yaw_rate = saturated(yaw_rate, truth_[gyro_range]),
          .accel_x = saturated(accel_x, truth_[accel_range]),
          .accel_y = saturated(accel_y, truth_[accel_range])};
}

WheelEncoder::WheelEncoder(const ParameterSet& truth, Wheel wheel, double configured_radius,
                           std::uint64_t seed)
    : wheel_(wheel),
      radius_(configured_radius),
      truth_(truth),
      stream_(seed, "wheel " + std::to_string(wheel)),
      phase_(stream_.uniform()) {}

double WheelEncoder::quantised_turns(double angle) const {
  const double turns = angle / (2.0 * std::numbers::pi);
  const double counts = truth_[encoder_counts];
  return counts > 0.0 ? std::floor(turns * counts + phase_) / counts : turns;
}

double WheelEncoder::read(const PlantOutput& car, double dt) {
  const double seen = quantised_turns(car.wheel_angle[wheel_]);
  const double before = quantised_turns(car.wheel_angle[wheel_] - car.wheel_rate[wheel_] * dt);
  const double moved = seen - last_.value_or(before);
  last_ = seen;
  const double noise = truth_[wheel_noise] * stream_.normal();
  if (moved == 0.0) return 0.0;
  const double speed = 2.0 * std::numbers::pi * radius_ * moved / dt + noise;
  return std::abs(speed) < truth_[wheel_dead_band] ? 0.0 : quantised(speed, truth_[wheel_step]);
}

SteeringSensor::SteeringSensor(const ParameterSet& truth, std::uint64_t seed)
    : truth_(truth), stream_(seed, "steering sensor") {}

double SteeringSensor::read(const PlantOutput& car) {
  const double angle = truth_[steering_commanded] > 0.5 ? car.commanded_steering : car.steering;
  const double read = (1.0 + truth_[steering_scale_error]) * angle + truth_[steering_offset] +
                      truth_[steering_noise] * stream_.normal();
  return saturated(quantised(read, truth_[steering_step]), truth_[steering_range]);
}

double wheel_speed_sigma(const ParameterSet& sizes, double configured_radius, double cycle_s) {
  // The difference of two roundings has a variance of 1/6 count².
  const double counts = sizes[encoder_counts];
  const double count =
      counts > 0.0 ? 2.0 * std::numbers::pi * configured_radius / counts / cycle_s : 0.0;
  return std::max(
      {std::hypot(sizes[wheel_noise], count / std::sqrt(6.0)), sizes[wheel_step], 1e-3});
}

double steering_sigma(const ParameterSet& sizes) {
  return std::max(std::hypot(sizes[steering_noise], sizes[steering_step] / std::sqrt(12.0)), 5e-4);
}

}  // namespace odomd::sim
