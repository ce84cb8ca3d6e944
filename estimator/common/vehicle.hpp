// Parameters of the vehicle models: a bicycle with mass, yaw inertia and two tyres.
#pragma once

#include <algorithm>
#include <cstdint>

namespace odomd::estimator {

/// Dynamics between a steering command and the front wheels. All 0 if the angle itself is measured.
struct SteeringActuator {
  double delay_s = 0.0;
  double lag_s = 0.0;       ///< time constant of a first-order lag
  double rate_limit = 0.0;  ///< [rad/s]; 0: none
};

/// Which axle the engine drives.
enum class Driven : std::uint8_t { rear, front, all };

/// SI units. The defaults are the reference car (the paper author's published 1:10 car).
/// Stiffnesses are positive, for a whole axle; the signs are in the formulas (errata, 2).
struct Vehicle {
  double mass = 2.985;                      ///< m [kg]
  double front_axle = 0.175;                ///< l_v [m], centre of gravity to front axle
  double rear_axle = 0.085;                 ///< l_h [m], centre of gravity to rear axle
  double yaw_inertia = 0.0283384;           ///< J_z [kg m²]
  double cornering_stiffness_front = 20.0;  ///< C_v [N/rad]
  double cornering_stiffness_rear = 60.0;   ///< C_h [N/rad]
  double track_width = 0.16;                ///< [m]
  double grip_front = 0.0;  ///< peak lateral force / mass on the axle [m/s²]; 0: linear tyres
  double grip_rear = 0.0;   ///< the same for the rear axle

  SteeringActuator steering;
  Driven driven = Driven::rear;

  [[nodiscard]] constexpr double wheelbase() const { return front_axle + rear_axle; }
};

/// The speed [m/s] at which the lateral motion settles within one `dt`; steps do not resolve it at
/// lower speeds. 0.185 m/s for the reference car at 5 ms.
[[nodiscard]] inline double slowest_resolved_speed(const Vehicle& car, double dt) noexcept {
  const double c_v = car.cornering_stiffness_front;
  const double c_h = car.cornering_stiffness_rear;
  const double l_v = car.front_axle;
  const double l_h = car.rear_axle;
  return dt *
         std::max((c_v + c_h) / car.mass, (l_v * l_v * c_v + l_h * l_h * c_h) / car.yaw_inertia);
}

}  // namespace odomd::estimator
