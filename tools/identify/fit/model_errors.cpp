// How far a fit can be trusted: the errors of its model.
#include "tools/identify/fit/findings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

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

/// At one speed, a larger steering scale looks like softer front tyres, and a camera farther ahead
/// looks like softer rear tyres, which drift more. An error in such a pair also shifts a third
/// parameter.
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

}  // namespace odomd::tools::fitting
