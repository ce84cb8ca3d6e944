#include "tools/sim/car/tyre.hpp"

#include <cmath>

namespace odomd::sim {

TyreForce tyre_force(const Tyre& tyre, double load, double friction, double slip_x, double slip_y) {
  const double limit = friction * load;
  if (limit <= 0.0) return {};
  const double growth = std::pow(load / tyre.nominal_load, tyre.load_exponent);
  // s_x = C_κ κ / (μ F_z),   s_y = C_α tan α / (μ F_z)
  const double s_x = tyre.slip_stiffness * growth * slip_x / limit;
  const double s_y = tyre.cornering_stiffness * growth * slip_y / limit;
  const double s = std::hypot(s_x, s_y);
  if (s < 1e-9) return {limit * s_x, limit * s_y};
  // F = μ F_z sin(c atan(s / c))
  const double force = limit * std::sin(tyre.shape * std::atan(s / tyre.shape));
  return {force * s_x / s, force * s_y / s};
}

}  // namespace odomd::sim
