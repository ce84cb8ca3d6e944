// The car as the models see it: a bicycle with a mass, a yaw inertia and two linear tyres.
#pragma once

namespace odomd::estimator {

/// SI units. The defaults are the reference car (the paper author's published 1:10 car).
/// Stiffnesses are positive, for a whole axle; the signs stand in the formulas (errata, 2).
struct Vehicle {
  double mass = 2.985;                      ///< m [kg]
  double front_axle = 0.175;                ///< l_v [m], centre of gravity to front axle
  double rear_axle = 0.085;                 ///< l_h [m], centre of gravity to rear axle
  double yaw_inertia = 0.0283384;           ///< J_z [kg m²]
  double cornering_stiffness_front = 20.0;  ///< C_v [N/rad]
  double cornering_stiffness_rear = 60.0;   ///< C_h [N/rad]
  double track_width = 0.16;                ///< [m]

  [[nodiscard]] constexpr double wheelbase() const { return front_axle + rear_axle; }
};

}  // namespace odomd::estimator
