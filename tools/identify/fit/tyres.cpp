// Converts the tyres of a fitted car to brush tyres, the filter's tyre model.
#include <cmath>
#include <limits>

#include "tools/identify/common/search.hpp"
#include "tools/identify/fit/findings.hpp"

namespace odomd::tools::fitting {
namespace {

/// The axle's share of the mass.
double mass_on(const car_model::Car<double>& car, Axle axle) {
  return (axle == Axle::front ? car.rear_axle : car.front_axle) / (car.front_axle + car.rear_axle) *
         car.mass;
}

/// Slip angle of a brush tyre / slip angle of a linear one, at u = F / F_max.
//   F = F_max (1 - (1 - q)³),  q = C α / (3 F_max), so C α / F_max = 3 (1 - ∛(1 - u))
double brush_slip(double u) {
  return 3.0 * (1.0 - std::cbrt(1.0 - u));
}

}  // namespace

double slip_at(const car_model::Car<double>& car, Axle axle, double accel) {
  constexpr double max_slip = 0.79;  // [rad]
  const bool front = axle == Axle::front;
  const double share = mass_on(car, axle);
  const double load = 0.5 * share * car_model::gravity;
  // The load transfer of car_model::push in a steady turn, limited to just below tipping over.
  const double shift = std::fmin(
      0.5 * car.mass * car.load_arm / car_model::load_exponent * accel / car.track / load, 0.95);
  const auto force = [&](double slip) {
    double sum = 0.0;
    for (const double side : {-shift, shift})
      sum += car_model::tyre_force(front ? car.stiffness_front : car.stiffness_rear,
                                   front ? car.bend_front : car.bend_rear, load, side, slip, 0.0);
    return sum;
  };
  if (!(force(max_slip) > share * accel)) return std::numeric_limits<double>::infinity();
  return bisect(0.0, max_slip, 50, [&](double slip) { return force(slip) < share * accel; });
}

std::optional<BrushTyre> brush_like(const car_model::Car<double>& car, Axle axle, double accel) {
  const double slip = slip_at(car, axle, accel);
  const double ratio = slip / slip_at(car, axle, 0.5 * accel);
  constexpr double linear = 2.0 + 1e-6;
  if (!std::isfinite(slip) || !(ratio > linear)) return std::nullopt;
  const double u =
      bisect(1e-6, 1.0, 50, [&](double x) { return brush_slip(x) / brush_slip(0.5 * x) < ratio; });
  const double grip = accel / u;
  return BrushTyre{.stiffness = mass_on(car, axle) * grip * brush_slip(u) / slip, .grip = grip};
}

}  // namespace odomd::tools::fitting
