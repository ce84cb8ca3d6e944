#include "tools/sim/car/cars.hpp"

#include <array>
#include <stdexcept>
#include <utility>

namespace odomd::sim {
namespace {

// The data's units: pounds (force), feet, slugs.
constexpr double foot = 0.3048;          // m
constexpr double slug = 14.593903;       // kg; also N/m of a lb/ft, N s/m of a lb s/ft
constexpr double foot_pound = 1.355818;  // N m; also kg m² of a slug ft²

// What is published of a car, in the units of its print. All numbers: M. Althoff and G. Würsching,
// "CommonRoad: Vehicle Models", TUM, parameter sets 1 to 3; these are of R. W. Allen et al.,
// "Vehicle Dynamic Stability and Rollover", DOT HS 807 956, 1992, whose names stand behind them,
// but for the tyre radius, the wheels' inertia and the tyres, which the set takes from elsewhere.
struct Published {
  double mass;           // slug, MASS
  double sprung_mass;    // slug, SMASS
  double front_axle;     // ft, LENA
  double rear_axle;      // ft, LENB
  double roll_inertia;   // slug ft², IXS
  double pitch_inertia;  // slug ft², IYS
  double yaw_inertia;    // slug ft², IZZ
  double spring_front;   // lb/ft, a wheel's, KSF
  double damper_front;   // lb s/ft, a wheel's, KSDF
  double spring_rear;    // KSR
  double damper_rear;    // KSDR
  double track_front;    // ft, TRWF
  double track_rear;     // ft, TRWB
  double bar_front;      // ft lb/rad, an axle's auxiliary roll stiffness, -KTSF
  double bar_rear;       // -KTSR
  double tyre_spring;    // lb/ft, a tyre's vertical rate, TSPRINGR
  double centre_height;  // ft, of the whole mass, HCG
  double sprung_height;  // ft, HS; the roll axis lies on the ground, HRAF = HRAR = 0
  double brake_front;    // share of the brakes, T_sb
  double drive_front;    // share of the drive, T_se
  double top_speed;      // m/s, v_max
  double drag;           // N s²/m², estimated: half of air's density by c_w A of the body's kind
};

// Parameter set 2: BMW 320i. Rear-wheel drive.
constexpr Published bmw{.mass = 74.91452,
                        .sprung_mass = 66.17221,
                        .front_axle = 3.793293,
                        .rear_axle = 4.667707,
                        .roll_inertia = 152.871,
                        .pitch_inertia = 1154.888,
                        .yaw_inertia = 1321.416,
                        .spring_front = 1675.0,
                        .damper_front = 122.3966,
                        .spring_rear = 1345.0,
                        .damper_rear = 112.9981,
                        .track_front = 4.55,
                        .track_rear = 4.475,
                        .bar_front = 5100.155,
                        .bar_rear = 1949.82,
                        .tyre_spring = 10842.89,
                        .centre_height = 1.886053,
                        .sprung_height = 2.01355,
                        .brake_front = 0.66,
                        .drive_front = 0.0,
                        .top_speed = 50.8,
                        .drag = 0.42};

// Parameter set 1: Ford Escort. Front-wheel drive.
constexpr Published escort{.mass = 84.0,
                           .sprung_mass = 75.0,
                           .front_axle = 2.9,
                           .rear_axle = 4.95,
                           .roll_inertia = 180.0,
                           .pitch_inertia = 990.0,
                           .yaw_inertia = 1135.0,
                           .spring_front = 1500.0,
                           .damper_front = 100.0,
                           .spring_rear = 1500.0,
                           .damper_rear = 100.0,
                           .track_front = 4.56,
                           .track_rear = 4.67,
                           .bar_front = 9500.0,
                           .bar_rear = 0.0,
                           .tyre_spring = 13000.0,
                           .centre_height = 1.83,
                           .sprung_height = 1.95,
                           .brake_front = 0.76,
                           .drive_front = 1.0,
                           .top_speed = 45.8,
                           .drag = 0.42};

// Parameter set 3: VW Vanagon. Engine and drive at the rear.
constexpr Published vanagon{.mass = 101.3367,
                            .sprung_mass = 90.21635,
                            .front_axle = 3.775563,
                            .rear_axle = 4.334437,
                            .roll_inertia = 353.9445,
                            .pitch_inertia = 1625.825,
                            .yaw_inertia = 1824.078,
                            .spring_front = 2300.0,
                            .damper_front = 164.8335,
                            .spring_rear = 2680.0,
                            .damper_rear = 189.7866,
                            .track_front = 5.165,
                            .track_rear = 5.065,
                            .bar_front = 25038.92,
                            .bar_rear = 5702.369,
                            .tyre_spring = 14565.6,
                            .centre_height = 2.453467,
                            .sprung_height = 2.639405,
                            .brake_front = 0.64,
                            .drive_front = 0.0,
                            .top_speed = 41.7,
                            .drag = 0.75};

// Common to the three sets: R_w, I_y_w, and the tyre of the ADAMS handbook, p_Ky1 (C_α / F_z),
// p_Kx1 (C_κ / F_z), p_Cy1 (shape); its friction p_Dy1 is a default in parameters.cpp. Its E is
// -0.007 and taken as 0. It is printed without a load sensitivity, and one of the usual size is
// given to it here.
constexpr double wheel_radius = 0.344, wheel_inertia = 1.7;
constexpr double cornering_stiffness_per_load = 21.92, slip_stiffness_per_load = 22.303;
constexpr double tyre_shape = 1.3507, tyre_load_exponent = 0.85;

const Published& published(CarKind car) {
  switch (car) {
    case CarKind::bmw_320i:
      return bmw;
    case CarKind::ford_escort:
      return escort;
    case CarKind::vw_vanagon:
      return vanagon;
    default:
      throw std::invalid_argument("there is no published data of this car");
  }
}

constexpr double in_series(double a, double b) {
  return a * b / (a + b);
}

// Of one axle, its two springs a track apart: roll stiffness k w² / 2, and likewise the damping.
// The tyres are springs in series with it, across which the dampers have no part of the way.
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

Suspension suspension(const Published& data) {
  const Axle front = axle(data.spring_front, data.damper_front, data.bar_front, data.track_front,
                          data.tyre_spring);
  const Axle rear =
      axle(data.spring_rear, data.damper_rear, data.bar_rear, data.track_rear, data.tyre_spring);
  const double a = data.front_axle * foot, b = data.rear_axle * foot;
  const double unsprung = data.mass - data.sprung_mass;
  return {.sprung_mass = data.sprung_mass * slug,
          .sprung_height = data.sprung_height * foot,
          // m h = m_s h_s + m_u h_u
          .unsprung_height =
              foot * (data.mass * data.centre_height - data.sprung_mass * data.sprung_height) /
              unsprung,
          .roll_inertia = data.roll_inertia * foot_pound,
          .pitch_inertia = data.pitch_inertia * foot_pound,
          .roll_stiffness_front = front.roll_stiffness,
          .roll_stiffness_rear = rear.roll_stiffness,
          .roll_damping_front = front.roll_damping,
          .roll_damping_rear = rear.roll_damping,
          .pitch_stiffness = a * a * front.ride_stiffness + b * b * rear.ride_stiffness,
          .pitch_damping = a * a * front.ride_damping + b * b * rear.ride_damping};
}

constexpr std::array names{
    std::pair{CarKind::scale_car, std::string_view("scale")},
    std::pair{CarKind::saloon, std::string_view("saloon")},
    std::pair{CarKind::bmw_320i, std::string_view("bmw_320i")},
    std::pair{CarKind::ford_escort, std::string_view("ford_escort")},
    std::pair{CarKind::vw_vanagon, std::string_view("vw_vanagon")},
};

}  // namespace

std::string car_names() {
  std::string all;
  for (const auto& [car, name] : names) all += (all.empty() ? "" : "|") + std::string(name);
  return all;
}

CarKind find_car(std::string_view name) {
  for (const auto& [car, known] : names)
    if (known == name) return car;
  throw std::invalid_argument("no car \"" + std::string(name) + "\"; available: " + car_names());
}

std::string_view car_name(CarKind car) {
  for (const auto& [known, name] : names)
    if (known == car) return name;
  return {};
}

PlantParameters published_car(CarKind car) {
  const Published& data = published(car);
  PlantParameters p;
  p.mass = data.mass * slug;
  p.front_axle = data.front_axle * foot;
  p.rear_axle = data.rear_axle * foot;
  p.yaw_inertia = data.yaw_inertia * foot_pound;
  p.track_width = 0.5 * (data.track_front + data.track_rear) * foot;
  p.track_difference = (data.track_front - data.track_rear) * foot;
  p.centre_height = data.centre_height * foot;
  p.suspension = suspension(data);

  const double load = p.mass * standard_gravity / (p.front_axle + p.rear_axle);
  p.cornering_stiffness_front = cornering_stiffness_per_load * load * p.rear_axle;
  p.cornering_stiffness_rear = cornering_stiffness_per_load * load * p.front_axle;
  p.slip_stiffness_ratio = slip_stiffness_per_load / cornering_stiffness_per_load;
  p.tyre_shape = tyre_shape;
  p.tyre_load_exponent = tyre_load_exponent;
  p.wheel_radius.fill(wheel_radius);
  p.wheel_inertia = wheel_inertia;

  p.drive_front_share = data.drive_front;
  p.brake_front_share = data.brake_front;
  p.top_speed = data.top_speed;
  p.drag = data.drag;
  // As for the saloon: not published.
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

}  // namespace odomd::sim
