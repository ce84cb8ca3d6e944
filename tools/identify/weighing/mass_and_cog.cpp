// odom identify mass and cog: mass from weighing the car as a whole or in parts; centre of gravity
// from the loads of axles and sides.
#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "daemon/core/config.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/inputs.hpp"
#include "tools/identify/weighing/weighing.hpp"

namespace odomd::tools {
namespace {

struct Options {
  std::array<std::vector<std::string>, static_cast<std::size_t>(Load::count)> loads;
  std::string resolution, sigma, accuracy, level = "0.25deg";
  std::string wheelbase, wheelbase_sigma = "1mm";
  std::string track_width, track_width_sigma = "1mm";
  std::string config;
  Delivery delivery;
};

struct Weighed {
  std::string origin;  ///< for the note: "scale, 3 weighings"
  WheelLoads loads;
  std::optional<Measured> mass;
};

/// Solves for the loads; their uncertainty allows for a floor that is not level.
Weighed weigh(const Options& options, Dimensions dimensions) {
  std::vector<Weighing> weighings;
  for (std::size_t i = 0; i < options.loads.size(); ++i)
    for (const auto load = static_cast<Load>(i); const std::string& text : options.loads[i])
      weighings.push_back(
          {load, parse_quantity(text, Dimension::mass, fmt::format("--{}", info_of(load).option))});
  Scale scale{
      .resolution = parse_or(0.0, options.resolution, Dimension::mass, "--scale-resolution"),
      .sigma = parse_or(0.0, options.sigma, Dimension::mass, "--scale-sigma"),
      .accuracy = parse_or(1e-3, options.accuracy, Dimension::pure, "--scale-accuracy")};
  if (scale.accuracy > 0.1)
    refuse(
        "--scale-accuracy: {} is more than 10 %; a number without % is a fraction (0.001 is 0.1%)",
        options.accuracy);
  dimensions.level = parse_not_negative(options.level, Dimension::angle, "--level");
  if (dimensions.level > 0.2)
    refuse("--level: with this slope the loads are useless; level the car");
  Weighed weighed{.origin = "scale, " + counted(weighings.size(), "weighing")};
  for (int round = 0; round < 2; ++round) {  // the load shifts need the mass
    weighed.loads = wheel_loads(weighings, scale);
    weighed.mass = mass_of(weighed.loads, scale);
    if (!weighed.mass) break;
    scale = with_slopes(scale, weighed.mass->value, dimensions);
  }
  return weighed;
}

/// Warns of loads that contradict each other, or otherwise of a mass with 2 % uncertainty or more,
/// whose units may be wrong.
void check_precision(const Weighed& weighed, Findings& findings) {
  constexpr const diagnostics::Kind& coarse = kind("scale_coarse");
  if (const auto line = contradiction(weighed.loads))
    findings.warnings.push_back(*line);
  else if (const auto& mass = weighed.mass;
           mass && !coarse.limits.hold(2.0 * mass->sigma / mass->value))
    add_warning(findings.warnings, coarse, {},
                "2 sigma of the mass is {:.1f} %, and 0.5 % is sufficient",
                200.0 * mass->sigma / mass->value);
}

/// A length from a tape; a sigma above a tenth of it must be in another unit.
Measured by_tape(const std::string& text, const std::string& sigma_text, const std::string& option,
                 Plausible range) {
  const double length = parse_plausible(text, Dimension::length, option, range);
  const double sigma = parse_not_negative(sigma_text, Dimension::length, option + "-sigma");
  if (sigma > 0.1 * length)
    refuse("{}-sigma: {} is more than a tenth of {:g} m; in metres, or write 1mm", option,
           sigma_text, length);
  return {length, sigma};
}

Dimensions dimensions_of(const Options& options) {
  Dimensions dimensions{.wheelbase = by_tape(options.wheelbase, options.wheelbase_sigma,
                                             "--wheelbase", {0.05, 10.0})};
  if (!options.track_width.empty())
    dimensions.track_width =
        by_tape(options.track_width, options.track_width_sigma, "--track-width", {0.02, 5.0});
  return dimensions;
}

/// Warns if the wheelbase is not that of the configuration.
void compare_with(const std::string& file, const Measured& wheelbase, Findings& findings) {
  const double configured = daemon::load_config(file).vehicle.wheelbase();
  if (std::fabs(configured - wheelbase.value) <=
      std::max(3.0 * wheelbase.sigma, 0.002 * wheelbase.value))
    return;
  add_warning(findings.warnings, kind("another_wheelbase"), file,
              "[vehicle] front_axle + rear_axle make a wheelbase of {:.4f} m, measured "
              "are {:.4f} m",
              configured, wheelbase.value);
}

Findings identify_mass(const Options& options) {
  // Only ratios matter: those of a usual car.
  const Weighed weighed =
      weigh(options, {.wheelbase = {1.0, 0.0}, .track_width = Measured{0.6, 0.0}});
  if (!weighed.mass)
    refuse(
        "the loads do not add up to the whole car; give --total, --front and --rear, or all "
        "wheels");
  Findings findings{.method = "mass", .origin = weighed.origin};
  findings.add("mass", "vehicle.mass", *weighed.mass, "kg");
  check_precision(weighed, findings);
  return findings;
}

Findings identify_cog(const Options& options) {
  const Dimensions dimensions = dimensions_of(options);
  const Weighed weighed = weigh(options, dimensions);
  check_shares(weighed.loads);
  const CentreOfGravity centre = centre_of_gravity(weighed.loads, dimensions);
  if (!centre.front_axle && !centre.lateral)
    refuse(
        "the loads do not determine the weight distribution; give --front and --rear (or --total "
        "with one of them), --left and --right, or all four wheels");

  Findings findings{.method = "cog", .origin = weighed.origin + " and tape"};
  const auto add = [&findings](const std::string& name, const std::string& key,
                               const std::optional<Measured>& measured,
                               const std::string& unit = "m",
                               const std::string& otherwise = "") -> Finding& {
    Finding& finding = findings.add(name, key, measured.value_or(Measured{}), unit);
    if (!measured) finding.reject(otherwise);
    return finding;
  };
  const std::string one_axle = "needs the load of one axle, and of the other or the whole car";
  add("centre of gravity to front axle", "vehicle.front_axle", centre.front_axle, "m", one_axle);
  add("centre of gravity to rear axle", "vehicle.rear_axle", centre.rear_axle, "m", one_axle);
  add("wheelbase", "", dimensions.wheelbase);
  if (dimensions.track_width) {
    add("track width", "vehicle.track_width", dimensions.track_width);
    add("centre of gravity left of the middle", "", centre.lateral, "m",
        "needs the load of one side, and of the other or the whole car")
        .share = Share::meaningless;
  }
  add("mass", "", weighed.mass, "kg");
  if (centre.front_axle) findings.details["correlation"] = centre.correlation;
  if (centre.lateral && std::fabs(centre.lateral->value) >
                            0.05 * dimensions.track_width->value + 2.0 * centre.lateral->sigma)
    add_warning(findings.warnings, kind("centre_off_side"), {},
                "the centre of gravity lies far to one side; the models assume it in the middle");
  check_precision(weighed, findings);
  if (const std::string file = options.config.empty() ? options.delivery.write : options.config;
      !file.empty())
    compare_with(file, dimensions.wheelbase, findings);
  return findings;
}

void add_scale_options(Command method, Options& options) {
  add_measured_option(method);
  for (std::size_t i = 0; i < options.loads.size(); ++i) {
    const auto load = static_cast<Load>(i);
    const char* units = " [kg], or 2985g; repeat the option for each weighing";
    method.add(fmt::format("--{}", info_of(load).option), "LOAD", options.loads[i],
               std::string(info_of(load).help) + (load == Load::total ? units : ""), {one_each()});
  }
  method.add("--scale-resolution", "LOAD", options.resolution,
             "Last digit that the scale shows [kg], or 1g");
  method.add("--scale-sigma", "LOAD", options.sigma,
             "Standard uncertainty of a weighing [kg], or 2g; default: half of the last digit");
  method.add("--scale-accuracy", "X", options.accuracy,
             "Standard uncertainty of the scale's gain, relative: 0.001, or 0.1%; default: 0.1%");
  method.add("--level", "ANGLE", options.level,
             "Standard uncertainty of the level of the car [rad], or 0.5deg; default: 0.25deg");
}

}  // namespace

void add_mass(Command identify) {
  const auto options = std::make_shared<Options>();
  Command method = identify.add_subcommand("mass", "Measure the car's mass on a scale");
  method.footer(
      R"(Put the car on the scale as it drives: battery in, body on, cables off. Weigh it three
times, and lift it off in between. If the scale is too small, weigh one axle at a time, with
the other one on a block as high as the scale: give --front and --rear, or all four wheels.

Precision: 0.5 % is sufficient. The uncertainty includes the scatter of the weighings, the
last digit of the scale, and the gain error of the scale. Repetition does not reduce the
gain error: weigh a litre of water to measure it. If axles or wheels are weighed, the
uncertainty also includes a slope of the car, which shifts load between scale and block.

Examples:
  odom identify mass --total 2.985 --total 2.986 --scale-resolution 1g
  odom identify mass --front 976g --rear 2009g --scale-resolution 1g
  odom identify mass --total 2985g --scale-resolution 1g --write car.toml)");
  add_scale_options(method, *options);
  add_delivery(method, options, identify_mass);
}

void add_cog(Command identify) {
  const auto options = std::make_shared<Options>();
  Command method = identify.add_subcommand(
      "cog", "Measure the centre of gravity between the axles, with a scale and a tape measure");
  method.footer(
      R"(Put one axle on the scale and the other on a block of the same height, so that the car
is level. Then weigh the other axle and, for the lateral offset, the left wheels and the
right ones. Weigh each three times, and lift the car in between. The wheels point straight
ahead, the tyres are at pressure, and the brakes are off, so that nothing pushes the axles
apart. Measure the wheelbase between the centres of the wheels, on both sides, and the track
width between the middles of the tyres.

Precision: the distance to an axle is as precise as its load (1 g in 1 kg is 0.1 %) and the
wheelbase. A slope of the car shifts it by height times slope: 0.2 mm for a height of 50 mm
and 0.25 degrees. The uncertainty includes this according to --level. A gain error of the
scale cancels.

Examples:
  odom identify cog --front 976g --rear 2009g --scale-resolution 1g --wheelbase 260mm
  odom identify cog --front 0.976 --total 2.985 --left 1.51 --right 1.475 \
      --scale-resolution 1g --scale-sigma 2g --wheelbase 0.26 --track-width 0.16 \
      --config car.toml
  odom identify cog --front 0.976 --rear 2.009 --scale-sigma 5g --wheelbase 0.26 \
      --wheelbase-sigma 0.5mm --write car.toml)");
  add_scale_options(method, *options);
  method.add("--wheelbase", "LENGTH", options->wheelbase,
             "Distance between the centres of front and rear wheels [m], or 260mm", {required()});
  method.add("--wheelbase-sigma", "LENGTH", options->wheelbase_sigma,
             "Standard uncertainty of the wheelbase; default: 1mm");
  method.add(
      "--track-width", "LENGTH", options->track_width,
      "Distance between the middles of left and right tyres [m], or 160mm; for the lateral offset");
  method.add("--track-width-sigma", "LENGTH", options->track_width_sigma,
             "Standard uncertainty of the track width; default: 1mm");
  method.add(
      "--config", "TOML", options->config,
      "Configuration of the car (TOML) to compare the wheelbase with; default: that of --write");
  add_delivery(method, options, identify_cog);
}

}  // namespace odomd::tools
