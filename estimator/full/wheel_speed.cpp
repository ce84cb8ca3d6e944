#include "estimator/full/wheel_speed.hpp"

namespace odomd::estimator::full {

WheelPlace wheel_place(const Vehicle& car, Source source) noexcept {
  const double half_track = 0.5 * car.track_width;
  switch (source) {
    case Source::wheel_front_left:
      return {car.front_axle, half_track, true, false};
    case Source::wheel_front_right:
      return {car.front_axle, -half_track, true, false};
    case Source::wheel_rear_left:
      return {-car.rear_axle, half_track, false, true};
    case Source::wheel_rear_right:
      return {-car.rear_axle, -half_track, false, true};
    default:  // the rear axle, the motor
      return {-car.rear_axle, 0.0, false, true};
  }
}

Prediction predict_wheel_speed(const CarModel& model, const WheelNoise& noise, const State& state,
                               Source source, double sigma, bool gyro) noexcept {
  const WheelPlace place = wheel_place(model.car, source);
  const Vector& x = state.mean;
  const double yaw_rate = x[at::yaw_rate];
  const double steering = state.steering.value - x[at::steering_offset];
  const double delta = place.steered && state.steering.seen ? steering : 0.0;
  const double c = std::cos(delta);
  const double s = std::sin(delta);
  const double along = x[at::v_x] - place.left * yaw_rate;
  const double across = x[at::v_y] + place.ahead * yaw_rate;
  const double rolling = along * c + across * s;
  const double scale = 1.0 + x[at::wheel_scale];

  // What drives the car beyond what its accelerometer feels: the front tyres' drag in a turn,
  // F_sv sin δ / m = (l_h / l) v ψ̇ sin δ.
  const double felt = state.accel_x.seen ? state.accel_x.value - x[at::accel_bias_x] : 0.0;
  const double drag = place.driven ? model.car.rear_axle / model.car.wheelbase() * x[at::v_x] *
                                         yaw_rate * std::sin(steering)
                                   : 0.0;
  const double slip = (place.driven ? noise.driven_slip : noise.free_slip) * (felt + drag);
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
