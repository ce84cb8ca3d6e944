// odom identify mass: on a scale, as a whole or by parts.
#include <memory>
#include <stdexcept>

#include "tools/identify/common/delivery.hpp"
#include "tools/identify/common/quantity.hpp"
#include "tools/identify/methods.hpp"
#include "tools/identify/weighing/scale_options.hpp"

namespace odomd::tools {
namespace {

struct Options {
  ScaleOptions scale;
  std::string wheelbase, track_width;
  LevelOptions level;
  Delivery delivery;
};

/// Only ratios count for the mass: for a car of unknown size the usual ones are taken.
Dimensions dimensions_of(const Options& options) {
  if (options.wheelbase.empty() && !(options.level.height.empty() && options.track_width.empty()))
    throw std::invalid_argument(
        "--wheelbase is missing, which is needed to check --height and --track-width");
  Dimensions dimensions;
  dimensions.wheelbase.value =
      options.wheelbase.empty()
          ? 1.0
          : parse_plausible(options.wheelbase, Dimension::length, "--wheelbase", {0.05, 10.0});
  constexpr double usual = 0.6;  // track width by wheelbase
  dimensions.track_width = Measured{
      options.track_width.empty()
          ? usual * dimensions.wheelbase.value
          : parse_plausible(options.track_width, Dimension::length, "--track-width", {0.02, 5.0}),
      0.0};
  set_level(options.level, dimensions);
  return dimensions;
}

void identify_mass(const Options& options) {
  check(options.delivery);
  Weighings weighings = weighings_of(options.scale);
  const WheelLoads loads = loads_on_slopes(weighings, dimensions_of(options));
  const auto mass = mass_of(loads, weighings.scale);
  if (!mass)
    throw std::invalid_argument(
        "the loads do not add up to the whole car; give --total, --front and --rear, or all "
        "wheels");
  Findings findings{.method = "mass", .origin = weighings.origin};
  findings.values = {as_finding("mass", "vehicle.mass", *mass, "kg")};
  if (const auto line = contradiction(loads))
    findings.warnings.push_back(*line);
  else if (const auto warning = coarse(*mass))
    findings.warnings.push_back(*warning);
  deliver(findings, options.delivery);
}

}  // namespace

void add_mass(Command identify) {
  const auto options = std::make_shared<Options>();
  Command method = identify.add_subcommand("mass", "Measure the car's mass on a scale");
  method.footer(
      R"(Put the car on the scale as it drives: battery in, body on, cables off. Weigh it three
times, lifting it off in between. A scale that is too small takes one axle at a time, the
other one on a block as high as the scale: give --front and --rear, or all four wheels.

Precision: 0.5 % is sufficient. The uncertainty contains the scatter of the weighings, the
last digit of the scale, and the scale's gain error. Repeating does not reduce the gain
error: weigh a litre of water to find it. If axles or wheels are weighed, it also contains
a slope of the car, which shifts load between the scale and the block.

Examples:
  odom identify mass --total 2.985 --total 2.986 --scale-resolution 1g
  odom identify mass --front 9.6N --rear 19.7N --scale-sigma 0.05N --gravity 9.8077
  odom identify mass --total 2985g --scale-resolution 1g --write car.toml)");
  add_scale_options(method, options->scale);
  method.add("--wheelbase", "LENGTH", options->wheelbase,
             "Distance between the centres of front and rear wheels [m], or 260mm; needed for "
             "--height and --track-width");
  method.add(
      "--track-width", "LENGTH", options->track_width,
      "Distance between the middles of left and right tyres [m], or 160mm; default: 0.6 of the "
      "wheelbase");
  add_level_options(method, options->level);
  add_delivery(method, options->delivery);
  method.callback([options] { identify_mass(*options); });
}

}  // namespace odomd::tools
