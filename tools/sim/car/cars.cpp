#include "tools/sim/car/plant.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace odomd::sim {
namespace {

// Units of the published data: pounds (force), feet, slugs.
constexpr double foot = 0.3048;          // m
constexpr double slug = 14.593903;       // kg; also converts lb/ft to N/m, lb s/ft to N s/m
constexpr double foot_pound = 1.355818;  // N m; also converts slug ft² to kg m²

// Published data of the cars, in the printed units. All numbers: M. Althoff and G. Würsching,
// "CommonRoad: Vehicle Models", TUM, parameter sets 1 to 3. Except for the tyre radius, the wheels'
// inertia and the tyres, these are from R. W. Allen et al., "Vehicle Dynamic Stability and
// Rollover", DOT HS 807 956, 1992, which has the names in the comments. One column per car: BMW
// 320i (rear-wheel drive, set 2), Ford Escort (front-wheel drive, set 1), VW Vanagon (engine and
// drive at the rear, set 3).
using Cars = std::array<double, 3>;
struct Published {
  Cars mass{74.91452, 84.0, 101.3367};            // slug, MASS
  Cars sprung_mass{66.17221, 75.0, 90.21635};     // slug, SMASS
  Cars front_axle{3.793293, 2.9, 3.775563};       // ft, LENA
  Cars rear_axle{4.667707, 4.95, 4.334437};       // ft, LENB
  Cars roll_inertia{152.871, 180.0, 353.9445};    // slug ft², IXS
  Cars pitch_inertia{1154.888, 990.0, 1625.825};  // slug ft², IYS
  Cars yaw_inertia{1321.416, 1135.0, 1824.078};   // slug ft², IZZ
  Cars spring_front{1675.0, 1500.0, 2300.0};      // lb/ft, one wheel, KSF
  Cars damper_front{122.3966, 100.0, 164.8335};   // lb s/ft, one wheel, KSDF
  Cars spring_rear{1345.0, 1500.0, 2680.0};       // KSR
  Cars damper_rear{112.9981, 100.0, 189.7866};    // KSDR
  Cars track_front{4.55, 4.56, 5.165};            // ft, TRWF
  Cars track_rear{4.475, 4.67, 5.065};            // ft, TRWB
  // ft lb/rad, auxiliary roll stiffness of an axle, -KTSF
  Cars bar_front{5100.155, 9500.0, 25038.92};
  Cars bar_rear{1949.82, 0.0, 5702.369};         // -KTSR
  Cars tyre_spring{10842.89, 13000.0, 14565.6};  // lb/ft, vertical rate of one tyre, TSPRINGR
  Cars centre_height{1.886053, 1.83, 2.453467};  // ft, of the whole mass, HCG
  // ft, HS; the roll axis is on the ground, HRAF = HRAR = 0
  Cars sprung_height{2.01355, 1.95, 2.639405};
  Cars brake_front{0.66, 0.76, 0.64};  // share of the brakes, T_sb
  Cars drive_front{0.0, 1.0, 0.0};     // share of the drive, T_se
  Cars top_speed{50.8, 45.8, 41.7};    // m/s, v_max
  // N s²/m², estimated: half the density of air times c_w A of this type of body
  Cars drag{0.42, 0.42, 0.75};
};
constexpr Published data;

// Common to the three sets: R_w, I_y_w, and the tyre of the ADAMS handbook, p_Ky1 (C_α / F_z),
// p_Kx1 (C_κ / F_z), p_Cy1 (shape); its friction p_Dy1 is a default in parameters.cpp. Its E of
// -0.007 is taken as 0. It is printed without a load sensitivity; the exponent here is a usual
// value.
constexpr double wheel_radius = 0.344, wheel_inertia = 1.7;
constexpr double cornering_stiffness_per_load = 21.92, slip_stiffness_per_load = 22.303;
constexpr double tyre_shape = 1.3507, tyre_load_exponent = 0.85;

// The column of a sprung car.
std::size_t published(CarKind car) {
  return static_cast<std::size_t>(car) - static_cast<std::size_t>(CarKind::bmw_320i);
}

constexpr double in_series(double a, double b) {
  return a * b / (a + b);
}

// One axle. Its springs and dampers, a track w apart, have the roll stiffness k w² / 2 and the
// damping c w² / 2. The tyres are springs in series, whose deflection does not move the dampers.
struct Axle {
  double roll_stiffness, roll_damping;
  double ride_stiffness, ride_damping;
};
Axle axle(double spring, double damper, double bar, double track, double tyre_spring) {
  const double k = spring * slug, c = damper * slug, w = track * foot, t = tyre_spring * slug;
  const double on_springs = 0.5 * k * w * w + bar * foot_pound;
  const double on_tyres = 0.5 * t * w * w;
  const double roll = in_series(on_springs, on_tyres), ride = in_series(k, t);
  const double roll_part = roll / on_springs, ride_part = ride / k;
  return {.roll_stiffness = roll,
          .roll_damping = 0.5 * c * w * w * roll_part * roll_part,
          .ride_stiffness = 2.0 * ride,
          .ride_damping = 2.0 * c * ride_part * ride_part};
}

Suspension suspension(std::size_t car) {
  const Axle front = axle(data.spring_front[car], data.damper_front[car], data.bar_front[car],
                          data.track_front[car], data.tyre_spring[car]);
  const Axle rear = axle(data.spring_rear[car], data.damper_rear[car], data.bar_rear[car],
                         data.track_rear[car], data.tyre_spring[car]);
  const double a = data.front_axle[car] * foot, b = data.rear_axle[car] * foot;
  const double unsprung = data.mass[car] - data.sprung_mass[car];
  return {.sprung_mass = data.sprung_mass[car] * slug,
          .sprung_height = data.sprung_height[car] * foot,
          // m h = m_s h_s + m_u h_u
          .unsprung_height = foot *
                             (data.mass[car] * data.centre_height[car] -
                              data.sprung_mass[car] * data.sprung_height[car]) /
                             unsprung,
          .roll_inertia = data.roll_inertia[car] * foot_pound,
          .pitch_inertia = data.pitch_inertia[car] * foot_pound,
          .roll_stiffness_front = front.roll_stiffness,
          .roll_stiffness_rear = rear.roll_stiffness,
          .roll_damping_front = front.roll_damping,
          .roll_damping_rear = rear.roll_damping,
          .pitch_stiffness = a * a * front.ride_stiffness + b * b * rear.ride_stiffness,
          .pitch_damping = a * a * front.ride_damping + b * b * rear.ride_damping};
}

constexpr std::array<std::string_view, 5> names{"scale", "saloon", "bmw_320i", "ford_escort",
                                                "vw_vanagon"};

// Properties of the 1:10 car that a configuration does not have: soft foam tyres, a brushless
// motor, a servo.
PlantParameters scale_car() {
  return {.centre_height = 0.04,
          .slip_stiffness_ratio = 3.0,
          .tyre_damping = 0.03,
          .rolling_resistance = 0.02,
          .drag = 0.01,
          .wheel_inertia = 3.3e-5,
          .motor_inertia = 6e-5,
          .roll_front_share = 0.5,
          .load_lag = 0.03,
          .top_speed = 15.0,
          .drive_lag = 0.03,
          .steering_limit = 0.5,
          .rest_speed = 0.001};
}

// A saloon of 1.7 t with a rigid body.
PlantParameters saloon() {
  return {.centre_height = 0.55,
          .slip_stiffness_ratio = 1.3,
          .tyre_damping = 0.02,
          .rolling_resistance = 0.012,
          .drag = 0.42,
          .wheel_inertia = 1.2,
          .motor_inertia = 1.0,
          .brake_front_share = 0.65,
          .roll_front_share = 0.55,
          .load_lag = 0.12,
          .top_speed = 60.0,
          .drive_lag = 0.1,
          .steering_limit = 0.55,
          .rest_speed = 0.004};
}

double millimetres(double length) {
  return std::round(1000.0 * length) / 1000.0;
}

PlantParameters usual_parameters(CarKind car) {
  if (car == CarKind::scale_car) return scale_car();
  return is_sprung(car) ? published_car(car) : saloon();
}

// Steering compliance of a sprung car, as a factor on the front cornering stiffness (typical;
// without it the car is neutral to loose). It is not in the tyre data, so not in the configuration.
constexpr double front_compliance = 0.85;

// All of `load` is sprung mass. Damping grows with the square root of the stiffness, so that the
// damping ratio stays.
Suspension true_suspension(Suspension s, double load, double stiffness) {
  s.sprung_mass += load;
  s.roll_stiffness_front *= stiffness;
  s.roll_stiffness_rear *= stiffness;
  s.roll_damping_front *= std::sqrt(stiffness);
  s.roll_damping_rear *= std::sqrt(stiffness);
  return s;
}

}  // namespace

std::string car_names() {
  return fmt::format("{}", fmt::join(names, "|"));
}

CarKind find_car(std::string_view name) {
  const auto* const found = std::ranges::find(names, name);
  if (found == names.end())
    throw std::invalid_argument(fmt::format("no car \"{}\"; available: {}", name, car_names()));
  return static_cast<CarKind>(found - names.begin());
}

std::string_view car_name(CarKind car) {
  return names[static_cast<std::size_t>(car)];
}

PlantParameters published_car(CarKind kind) {
  const std::size_t car = published(kind);
  PlantParameters p;
  p.mass = data.mass[car] * slug;
  p.front_axle = data.front_axle[car] * foot;
  p.rear_axle = data.rear_axle[car] * foot;
  p.yaw_inertia = data.yaw_inertia[car] * foot_pound;
  p.track_width = 0.5 * (data.track_front[car] + data.track_rear[car]) * foot;
  p.track_difference = (data.track_front[car] - data.track_rear[car]) * foot;
  p.centre_height = data.centre_height[car] * foot;
  p.suspension = suspension(car);

  const double load = p.mass * standard_gravity / (p.front_axle + p.rear_axle);
  p.cornering_stiffness_front = cornering_stiffness_per_load * load * p.rear_axle;
  p.cornering_stiffness_rear = cornering_stiffness_per_load * load * p.front_axle;
  p.slip_stiffness_ratio = slip_stiffness_per_load / cornering_stiffness_per_load;
  p.tyre_shape = tyre_shape;
  p.tyre_load_exponent = tyre_load_exponent;
  p.wheel_radius.fill(wheel_radius);
  p.wheel_inertia = wheel_inertia;

  p.drive_front_share = data.drive_front[car];
  p.brake_front_share = data.brake_front[car];
  p.top_speed = data.top_speed[car];
  p.drag = data.drag[car];
  // Not published; as for the saloon.
  p.tyre_damping = 0.02;
  p.rolling_resistance = 0.012;
  p.motor_inertia = 1.0;
  p.torque_limit = 0.6;
  p.load_lag = 0.02;
  p.drive_lag = 0.1;
  p.steering_limit = 0.6;
  p.rest_speed = 0.004;
  return p;
}

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
