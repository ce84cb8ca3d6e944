#include "tools/identify/weighing/scale_options.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/identify/common/quantity.hpp"

namespace odomd::tools {
void add_measured_option(Command method) {
  method.add_measurements(
      "--measured", "JSON",
      "Measurements written down in a file: {\"total\": [2.985, 2.986], "
      "\"spacing\": \"200mm\"}; names are those of the options, with underscores");
}

void add_gravity_option(Command method, std::string& gravity) {
  method.add("--gravity", "G", gravity,
             "Local gravity [m/s2], known to 0.001; default: 9.806 +- 0.015, anywhere on Earth");
}

Measured gravity_of(const std::string& gravity) {
  // Between equator (9.780) and poles (9.832).
  if (gravity.empty()) return {9.806, 0.015};
  const double value = parse_positive(gravity, Dimension::pure, "--gravity");
  if (value < 9.7 || value > 9.9)
    throw std::invalid_argument("--gravity: " + gravity +
                                " does not occur on Earth; give 9.76 to 9.84");
  return {value, 0.001};
}

void add_scale_options(Command method, ScaleOptions& options) {
  add_measured_option(method);
  for (std::size_t i = 0; i < options.loads.size(); ++i) {
    const auto load = static_cast<Load>(i);
    method
        .add("--" + std::string(info_of(load).option), "LOAD", options.loads[i],
             std::string(info_of(load).help) +
                 (load == Load::total
                      ? " [kg], or 2985g, or 29.3N; repeat the option for each weighing"
                      : ""))
        .one_each();
  }
  method.add("--scale-resolution", "LOAD", options.resolution,
             "Last digit that the scale shows [kg], or 1g");
  method.add("--scale-sigma", "LOAD", options.sigma,
             "Standard uncertainty of a weighing [kg], or 2g; default: half of the last digit");
  method.add("--scale-accuracy", "X", options.accuracy,
             "Standard uncertainty of the scale's gain, relative: 0.001, or 0.1%; default: 0.1%");
  add_gravity_option(method, options.gravity);
}

Weighings weighings_of(const ScaleOptions& options) {
  Weighings result;
  const Measured gravity = gravity_of(options.gravity);
  bool newtons = false;
  const auto kilograms = [&](const std::string& text, const std::string& option) {
    const Quantity quantity = parse_quantity(text, Dimension::mass, option);
    if (quantity.unit == Unit::si) return quantity.value;
    newtons = true;
    return quantity.value / gravity.value;
  };
  for (std::size_t i = 0; i < options.loads.size(); ++i) {
    const auto load = static_cast<Load>(i);
    for (const std::string& text : options.loads[i])
      result.weighings.push_back({load, kilograms(text, "--" + std::string(info_of(load).option))});
  }
  const auto not_negative = [&](const std::string& text, const std::string& option) {
    const double value = kilograms(text, option);
    if (value < 0.0)
      throw std::invalid_argument(option + ": " + text + " is not possible; it must be 0 or more");
    return value;
  };
  if (!options.resolution.empty())
    result.scale.resolution = not_negative(options.resolution, "--scale-resolution");
  if (!options.sigma.empty()) result.scale.sigma = not_negative(options.sigma, "--scale-sigma");
  result.scale.accuracy = parse_or(1e-3, options.accuracy, Dimension::pure, "--scale-accuracy");
  constexpr double worst_gain = 0.1;
  if (result.scale.accuracy > worst_gain)
    throw std::invalid_argument("--scale-accuracy: " + options.accuracy +
                                " is more than a tenth; write per cent as 0.1%");
  if (newtons)  // a weight is a mass only as well as gravity is known
    result.scale.accuracy = std::hypot(result.scale.accuracy, gravity.sigma / gravity.value);
  result.origin = "scale, " + counted(result.weighings.size(), "weighing");
  return result;
}

void add_level_options(Command method, LevelOptions& options) {
  method.add(
      "--height", "LENGTH", options.height,
      "Approximate height of the centre of gravity above the ground [m]; default: a quarter of "
      "the wheelbase");
  method.add("--level", "ANGLE", options.level,
             "Standard uncertainty of the level of the car [rad], or 0.5deg; default: 0.25deg");
}

void set_level(const LevelOptions& options, Dimensions& dimensions) {
  // Unknown, it is a quarter of the wheelbase for cars of any size, give or take.
  dimensions.height =
      parse_or(0.25 * dimensions.wheelbase.value, options.height, Dimension::length, "--height");
  dimensions.level_sigma = parse_not_negative(options.level, Dimension::angle, "--level");
  if (dimensions.level_sigma > 0.2)
    throw std::invalid_argument("--level: with this slope the loads are useless; level the car");
}

std::optional<diagnostics::Diagnostic> coarse(const Measured& mass) {
  constexpr const diagnostics::Kind& coarse = diagnostics::kind("scale_coarse");
  if (coarse.limits.hold(2.0 * mass.sigma / mass.value)) return std::nullopt;
  return found(coarse, {},
               fmt::format("2 sigma of the mass is {:.1f} %, and 0.5 % is sufficient",
                           200.0 * mass.sigma / mass.value));
}

WheelLoads loads_on_slopes(Weighings& weighings, const Dimensions& dimensions) {
  const WheelLoads loads = wheel_loads(weighings.weighings, weighings.scale);
  const auto mass = mass_of(loads, weighings.scale);
  if (!mass) return loads;
  weighings.scale = with_slopes(weighings.scale, mass->value, dimensions);
  return wheel_loads(weighings.weighings, weighings.scale);
}

}  // namespace odomd::tools
