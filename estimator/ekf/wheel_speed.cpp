#include "estimator/ekf/wheel_speed.hpp"

#include <algorithm>

namespace odomd::estimator::full {
namespace {

// Where nobody tells: no front wheel turns further, and below this speed [m/s] its way says
// nothing.
constexpr double largest_steering = 0.6;
constexpr double slowest_steered = 0.3;
// No tyre makes more [m/s²]: an accelerometer that reads more is broken, and says nothing of slip.
constexpr double strongest_grip = 12.0;

/// δ: as measured, or as the front axle goes, atan((v_y + l_v ψ̇) / v_x).
double steering_of(const Vehicle& car, const Input& input, const Vector& x) noexcept {
  if (input.has_steering) {
    return input.steering - x[at::steering_offset];
  }
  const double v_x = x[at::v_x];
  if (std::abs(v_x) < slowest_steered) {
    return 0.0;
  }
  const double goes = std::atan((x[at::v_y] + car.front_axle * x[at::yaw_rate]) / v_x);
  return std::clamp(goes, -largest_steering, largest_steering);
}

}  // namespace

WheelPlace wheel_place(const Vehicle& car, Source source) noexcept {
  const double half_track = 0.5 * car.track_width;
  switch (source) {
    case Source::wheel_front_left:
      return {car.front_axle, half_track, true};
    case Source::wheel_front_right:
      return {car.front_axle, -half_track, true};
    case Source::wheel_rear_left:
      return {-car.rear_axle, half_track, false};
    case Source::wheel_rear_right:
      return {-car.rear_axle, -half_track, false};
    default:  // the rear axle, the motor
      return {-car.rear_axle, 0.0, false};
  }
}

Prediction predict_wheel_speed(const CarModel& model, const WheelNoise& noise, const Input& input,
                               const State& state, Source source, double sigma,
                               bool gyro) noexcept {
  const WheelPlace place = wheel_place(model.car, source);
  const Vector& x = state.mean;
  const double yaw_rate = x[at::yaw_rate];
  const double steering = steering_of(model.car, input, x);
  const double delta = place.steered ? steering : 0.0;
  const double c = std::cos(delta);
  const double s = std::sin(delta);
  const double along = x[at::v_x] - place.left * yaw_rate;
  const double across = x[at::v_y] + place.ahead * yaw_rate;
  const double rolling = along * c + across * s;
  const double scale = 1.0 + x[at::wheel_scale];

  // What drives the car beyond what its accelerometer feels: the front tyres' drag in a turn,
  // F_sv sin δ / m = (l_h / l) v ψ̇ sin δ.
  const double felt = input.has_accel_x ? input.accel_x - x[at::accel_bias_x] : 0.0;
  const bool driven = is_driven(source);
  const double drag = driven ? model.car.rear_axle / model.car.wheelbase() * x[at::v_x] * yaw_rate *
                                   std::sin(steering)
                             : 0.0;
  const double slip = (driven ? noise.driven_slip : noise.free_slip) *
                      std::clamp(felt + drag, -strongest_grip, strongest_grip);
  const double by_yaw_rate = -place.left * c + place.ahead * s;
  const double by_delta = place.steered ? across * c - along * s : 0.0;

  Prediction z;
  z.value = scale * rolling;
  const auto squared = [](double value) { return value * value; };
  z.variance = squared(sigma) + (squared(noise.radius) + squared(slip)) * squared(rolling) +
               squared(by_delta * noise.front_angle) +
               squared(s) * state.covariance(at::v_y, at::v_y);
  z.depends_on(at::v_x, scale * c);
  z.depends_on(at::wheel_scale, rolling);
  if (gyro) {
    z.variance += squared(by_yaw_rate) * state.covariance(at::yaw_rate, at::yaw_rate);
  } else {
    z.depends_on(at::yaw_rate, scale * by_yaw_rate);
  }
  return z;
}

}  // namespace odomd::estimator::full
