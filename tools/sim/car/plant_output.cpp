#include "tools/sim/car/plant_output.hpp"

#include <bit>
#include <cmath>

#include "tools/sim/car/chassis.hpp"

namespace odomd::sim {

PlantOutput interpolate(const PlantOutput& from, const PlantOutput& to, double part) {
  using Numbers = std::array<double, sizeof(PlantOutput) / sizeof(double)>;
  auto a = std::bit_cast<Numbers>(from);
  const auto b = std::bit_cast<Numbers>(to);
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += part * (b[i] - a[i]);
  return std::bit_cast<PlantOutput>(a);
}

BodyForce specific_force_at(const PlantOutput& o, double x, double y, double z) {
  // a(p) = a + ψ̈ × p - ψ̇² p: Euler and centripetal terms of the lever arm
  if (o.is_level())
    return {o.accel_x - o.yaw_accel * y - o.yaw_rate * o.yaw_rate * x,
            o.accel_y + o.yaw_accel * x - o.yaw_rate * o.yaw_rate * y};

  // f = a + g n on the road, seen from the body, R = R_y(θ) R_x(φ)
  const Up up = up_on({.grade = o.grade, .bank = o.bank});
  const double f_x = o.accel_x + standard_gravity * up.x;
  const double f_y = o.accel_y + standard_gravity * up.y;
  const double f_z = standard_gravity * up.z;
  const double along = std::cos(o.pitch) * f_x - std::sin(o.pitch) * f_z;
  const double upward = std::sin(o.pitch) * f_x + std::cos(o.pitch) * f_z;
  const double across = std::cos(o.roll) * f_y + std::sin(o.roll) * upward;

  // f(p) = f + ω̇ × p + ω × (ω × p) = f + ω̇ × p + ω (ω · p) - ω² p
  const double p = o.roll_rate + o.bank_rate;
  const double q = o.pitch_rate - o.grade_rate;
  const double r = body_yaw_rate(o);
  const double on_axis = p * x + q * y + r * z;
  const double squared = p * p + q * q + r * r;
  return {along + o.pitch_accel * z - o.yaw_accel * y + p * on_axis - squared * x,
          across + o.yaw_accel * x - o.roll_accel * z + q * on_axis - squared * y};
}

// ω_z = ψ̇ cos θ cos φ - θ̇ sin φ, with the angles of the body against the horizon
double body_yaw_rate(const PlantOutput& o) {
  if (o.is_level()) return o.yaw_rate;
  const double over_roll = o.roll + o.bank, over_pitch = o.pitch - o.grade;
  return o.yaw_rate * std::cos(over_pitch) * std::cos(over_roll) -
         (o.pitch_rate - o.grade_rate) * std::sin(over_roll);
}

}  // namespace odomd::sim
