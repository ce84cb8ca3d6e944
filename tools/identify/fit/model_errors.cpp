// How far a fit can be trusted, and what the filter gets from it: the errors of its model, and
// brush tyres.
#include "tools/identify/fit/findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tools/math/least_squares.hpp"

namespace odomd::tools::fitting {
namespace {

Numbers<double> at_many_speeds(double wheelbase) {
  return sigmas_of(&ParameterInfo::model_error, wheelbase);
}

constexpr double exercise_speed_variety = 0.4;  // of the help's exercise, which suffices
constexpr double max_factor = 30.0;

/// Factor on the allowance for parameters that only different speeds separate, from the errors in
/// simulated laps and slaloms at one speed.
double widening(double variety) {
  return std::clamp(std::pow(exercise_speed_variety / std::max(variety, 1e-3), 2), 1.0, max_factor);
}

/// At one speed, softer front tyres with a larger steering scale fit equally well, as do softer
/// rear tyres with a camera farther ahead. An error in such a pair also shifts a third parameter.
struct LookAlikes {
  Parameter tyres, other, third;
};
constexpr std::array all_look_alikes{LookAlikes{stiffness_front, steering_scale, steering_offset},
                                     LookAlikes{stiffness_rear, camera_x, imu_x}};

/// The pairs in which neither parameter is known beforehand as precisely as a fit over many speeds
/// would determine it.
std::vector<LookAlikes> open_pairs(double wheelbase, const Settings& settings) {
  const Numbers<double> sigma = at_many_speeds(wheelbase);
  const auto open = [&](Parameter k) {
    return settings.free[k] && settings.prior_sigma[k] > sigma[k];
  };
  std::vector<LookAlikes> pairs;
  for (const LookAlikes& pair : all_look_alikes)
    if (open(pair.tyres) && open(pair.other)) pairs.push_back(pair);
  return pairs;
}

}  // namespace

std::vector<std::size_t> Settings::free_parameters() const {
  std::vector<std::size_t> ones;
  for (std::size_t k = 0; k < parameters; ++k)
    if (free[k]) ones.push_back(k);
  return ones;
}

Measured Settings::known(std::size_t k) const {
  if (k != gyro_bias || !rest) return {0.0, prior_sigma[k]};
  const double by_rest = 1.0 / (rest->sigma * rest->sigma),
               all = by_rest + 1.0 / (prior_sigma[k] * prior_sigma[k]);
  return {rest->value * by_rest / all, 1.0 / std::sqrt(all)};
}

bool at_one_speed(double wheelbase, const Settings& settings, double variety) {
  return widening(variety) > 2.0 && !open_pairs(wheelbase, settings).empty();
}

std::optional<Parameter> twin(double wheelbase, const Settings& settings, double variety,
                              Parameter k) {
  if (!at_one_speed(wheelbase, settings, variety)) return std::nullopt;
  for (const LookAlikes& pair : open_pairs(wheelbase, settings)) {
    if (k == pair.tyres) return pair.other;
    if (k == pair.other) return pair.tyres;
  }
  return std::nullopt;
}

Numbers<double> allowance(double wheelbase, const Settings& settings, double variety) {
  Numbers<double> sigma = at_many_speeds(wheelbase);
  for (const LookAlikes& pair : open_pairs(wheelbase, settings))
    for (const Parameter k : {pair.tyres, pair.other, pair.third}) sigma[k] *= widening(variety);
  return sigma;
}

// Converts the tyres of a fitted car to brush tyres, the filter's tyre model.
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
