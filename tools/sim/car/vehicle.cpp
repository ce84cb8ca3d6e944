#include "tools/sim/car/vehicle.hpp"

#include <algorithm>
#include <cmath>

#include "tools/sim/car/cars.hpp"

namespace odomd::sim {
namespace {

// Properties of the 1:10 car that are not in a configuration: soft foam tyres, a brushless motor, a
// servo.
PlantParameters scale_car() {
  PlantParameters p;
  p.centre_height = 0.04;
  p.slip_stiffness_ratio = 3.0;
  p.tyre_damping = 0.03;
  p.rolling_resistance = 0.02;
  p.drag = 0.01;
  p.wheel_inertia = 3.3e-5;
  p.motor_inertia = 6e-5;
  p.roll_front_share = 0.5;
  p.load_lag = 0.03;
  p.top_speed = 15.0;
  p.drive_lag = 0.03;
  p.steering_limit = 0.5;
  p.rest_speed = 0.001;
  return p;
}

// A saloon of 1.7 t, on rigid springs.
PlantParameters saloon() {
  PlantParameters p;
  p.centre_height = 0.55;
  p.slip_stiffness_ratio = 1.3;
  p.tyre_damping = 0.02;
  p.rolling_resistance = 0.012;
  p.drag = 0.42;
  p.wheel_inertia = 1.2;
  p.motor_inertia = 1.0;
  p.brake_front_share = 0.65;
  p.roll_front_share = 0.55;
  p.load_lag = 0.12;
  p.top_speed = 60.0;
  p.drive_lag = 0.1;
  p.steering_limit = 0.55;
  p.rest_speed = 0.004;
  return p;
}

double millimetres(double length) {
  return std::round(1000.0 * length) / 1000.0;
}

PlantParameters usual_parameters(CarKind car) {
  if (car == CarKind::scale_car) return scale_car();
  return is_sprung(car) ? published_car(car) : saloon();
}

// What is left of the front tyres' stiffness on a sprung car, whose steering gives way to them: a
// typical value, without which its axles would be balanced and its tail loose. Its owner, who reads
// the data of the tyres, does not know of it.
constexpr double front_compliance = 0.85;

// The load of a car that is heavier than published sits on its springs. Dampers go with the springs
// so that the body rolls out as many times as before.
Suspension true_suspension(Suspension s, double load, double stiffness) {
  s.sprung_mass += load;
  s.roll_stiffness_front *= stiffness;
  s.roll_stiffness_rear *= stiffness;
  s.roll_damping_front *= std::sqrt(stiffness);
  s.roll_damping_rear *= std::sqrt(stiffness);
  return s;
}

}  // namespace

estimator::Vehicle configured_vehicle(CarKind car) {
  if (car == CarKind::scale_car) return {};  // the reference car
  if (is_sprung(car)) {
    const PlantParameters p = published_car(car);
    return {
        .mass = std::round(p.mass),
        .front_axle = millimetres(p.front_axle),
        .rear_axle = millimetres(p.rear_axle),
        .yaw_inertia = std::round(p.yaw_inertia),
        .cornering_stiffness_front = 1000.0 * std::round(0.001 * p.cornering_stiffness_front),
        .cornering_stiffness_rear = 1000.0 * std::round(0.001 * p.cornering_stiffness_rear),
        .track_width = millimetres(p.track_width),
        .driven = p.drive_front_share > 0.5 ? estimator::Driven::front : estimator::Driven::rear};
  }
  return {.mass = 1700.0,
          .front_axle = 1.25,
          .rear_axle = 1.45,
          .yaw_inertia = 2800.0,
          .cornering_stiffness_front = 110e3,
          .cornering_stiffness_rear = 135e3,
          .track_width = 1.58};
}

double configured_wheel_radius(CarKind car) {
  if (is_sprung(car)) return published_car(car).wheel_radius.front();
  return car == CarKind::scale_car ? 0.033 : 0.32;
}

PlantParameters true_vehicle(CarKind car, const ParameterSet& truth) {
  using enum Parameter;
  const estimator::Vehicle configured = configured_vehicle(car);
  PlantParameters p = usual_parameters(car);
  p.mass = configured.mass * (1.0 + truth[mass_error]);
  p.front_axle = configured.front_axle;
  p.rear_axle = configured.rear_axle;
  p.yaw_inertia = configured.yaw_inertia * (1.0 + truth[inertia_error]);
  p.track_width = configured.track_width;
  p.cornering_stiffness_front = configured.cornering_stiffness_front *
                                (1.0 + truth[stiffness_error_front]) *
                                (is_sprung(car) ? front_compliance : 1.0);
  p.cornering_stiffness_rear =
      configured.cornering_stiffness_rear * (1.0 + truth[stiffness_error_rear]);
  p.friction = truth[friction];
  p.relaxation_length = truth[relaxation_length];
  p.steering_delay = truth[steering_delay];
  p.steering_lag = truth[steering_lag];
  p.steering_rate_limit = truth[steering_rate_limit];
  p.suspension = is_sprung(car) ? true_suspension(p.suspension, p.mass - configured.mass,
                                                  truth[roll_stiffness])
                                : Suspension{};
  const double radius = configured_wheel_radius(car) * (1.0 + truth[wheel_radius_error]);
  p.wheel_radius = {radius * (1.0 + truth[wheel_radius_error_front_left]),
                    radius * (1.0 + truth[wheel_radius_error_front_right]),
                    radius * (1.0 + truth[wheel_radius_error_rear_left]),
                    radius * (1.0 + truth[wheel_radius_error_rear_right])};
  return p;
}

}  // namespace odomd::sim
