// The force of one tyre: saturating, load-dependent, longitudinal and lateral slip combined.
//
// The two slips are brought to one scale, the force that each would give if the tyre were linear
// over the force that the road can give:
//
//   s_x = C_κ κ / (μ F_z),   s_y = C_α tan α / (μ F_z),   s = √(s_x² + s_y²)
//
// and the resultant follows Pacejka's sine with unit initial slope (B = 1/c, D = 1, E = 0):
//
//   F = μ F_z sin(c atan(s / c)),   along (s_x, s_y)
//
// so that the slopes at zero slip are C_κ and C_α exactly, the force never exceeds the friction
// circle μ F_z, and beyond the peak it falls. Both stiffnesses grow less than in proportion to the
// load: C(F_z) = C(F_z0) (F_z / F_z0)^p, p < 1, which is what makes load transfer cost grip.
// (H. Pacejka, Tire and Vehicle Dynamics, chapters 3 and 4.)
#pragma once

namespace odomd::sim {

struct Tyre {
  double cornering_stiffness = 0.0;  ///< C_α at the nominal load [N/rad]
  double slip_stiffness = 0.0;       ///< C_κ at the nominal load [N]
  double nominal_load = 0.0;         ///< F_z0 [N]
  double shape = 1.35;               ///< c; 1 saturates without a peak, up to 2
  double load_exponent = 0.8;        ///< p
};

struct TyreForce {
  double x = 0.0;  ///< along the wheel [N]
  double y = 0.0;  ///< to its left [N]
};

/// `slip_x` is κ (positive when the wheel drives), `slip_y` is tan α (positive when it pushes to
/// the left). A wheel without load gives no force.
[[nodiscard]] TyreForce tyre_force(const Tyre& tyre, double load, double friction, double slip_x,
                                   double slip_y);

}  // namespace odomd::sim
