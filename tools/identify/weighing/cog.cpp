// odom identify cog: where the centre of gravity lies, from the loads of axles and sides.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/identify/common/delivery.hpp"
#include "tools/identify/common/quantity.hpp"
#include "tools/identify/methods.hpp"
#include "tools/identify/weighing/scale_options.hpp"

namespace odomd::tools {
namespace {

struct Options {
  ScaleOptions scale;
  std::string wheelbase, wheelbase_sigma = "1mm";
  std::string track_width, track_width_sigma = "1mm";
  LevelOptions level;
  std::string config;
  Delivery delivery;
};

/// How well a length was measured; a tape that is off by a tenth is one in another unit.
double tape_sigma(const std::string& text, const std::string& option, double length) {
  const double sigma = parse_not_negative(text, Dimension::length, option);
  if (sigma > 0.1 * length)
    throw std::invalid_argument(
        fmt::format("{}: {} is more than a tenth of {:g} m; in metres, or "
                    "write 1mm",
                    option, text, length));
  return sigma;
}

Dimensions dimensions_of(const Options& options) {
  Dimensions dimensions;
  const double base =
      parse_plausible(options.wheelbase, Dimension::length, "--wheelbase", {0.05, 10.0});
  dimensions.wheelbase = {base, tape_sigma(options.wheelbase_sigma, "--wheelbase-sigma", base)};
  if (!options.track_width.empty()) {
    const double width =
        parse_plausible(options.track_width, Dimension::length, "--track-width", {0.02, 5.0});
    dimensions.track_width =
        Measured{width, tape_sigma(options.track_width_sigma, "--track-width-sigma", width)};
  }
  set_level(options.level, dimensions);
  return dimensions;
}

/// Is it the same car?
void check_wheelbase(const std::string& file, const Measured& wheelbase, Findings& findings) {
  const estimator::Vehicle car = daemon::load_config(file).vehicle;
  const double configured = car.front_axle + car.rear_axle;
  const double apart = std::fabs(configured - wheelbase.value);
  if (apart > std::max(3.0 * wheelbase.sigma, 0.002 * wheelbase.value))
    findings.warnings.push_back(
        found(diagnostics::kind("another_wheelbase"), file,
              fmt::format("[vehicle] front_axle + rear_axle make a wheelbase of {:.4f} m, measured "
                          "are {:.4f} m",
                          configured, wheelbase.value)));
}

/// Is the heavy end where the configuration has it?
void check_ends(const std::string& file, const CentreOfGravity& centre, Findings& findings) {
  const auto front = number_in(file, "vehicle.front_axle");
  const auto rear = number_in(file, "vehicle.rear_axle");
  if (!front || !rear || !centre.front_axle || !centre.rear_axle) return;
  const double configured = *front - *rear;
  const double measured = centre.front_axle->value - centre.rear_axle->value;
  constexpr double clear = 0.05;  // of the wheelbase
  if (configured * measured > 0.0 || std::fabs(configured) < clear * (*front + *rear) ||
      std::fabs(measured) < clear * (centre.front_axle->value + centre.rear_axle->value))
    return;
  findings.warnings.push_back(found(
      diagnostics::kind("axles_exchanged"), file,
      fmt::format("with [vehicle] front_axle {:g} and rear_axle {:g} the {} axle is the heavier "
                  "one, but by the loads it is the {} one",
                  *front, *rear, configured > 0.0 ? "rear" : "front",
                  measured > 0.0 ? "rear" : "front")));
}

void identify_cog(const Options& options) {
  check(options.delivery);
  Weighings weighings = weighings_of(options.scale);
  const Dimensions dimensions = dimensions_of(options);
  const WheelLoads loads = loads_on_slopes(weighings, dimensions);
  check_shares(loads);
  const CentreOfGravity centre = centre_of_gravity(loads, dimensions);
  if (!centre.front_axle && !centre.lateral)
    throw std::invalid_argument(
        "the loads do not determine the weight distribution; give --front and --rear (or --total "
        "with one of them), --left and --right, or all four wheels");

  Findings findings{.method = "cog", .origin = weighings.origin + " and tape"};
  const auto add = [&findings](const std::string& name, const std::string& key,
                               const std::optional<Measured>& measured,
                               const std::string& otherwise, Share share = Share::meaningful) {
    Finding finding = as_finding(name, key, measured.value_or(Measured{}), "m");
    finding.share = share;
    findings.values.push_back(measured ? finding : undetermined(finding, otherwise));
  };
  const std::string one_axle = "needs the load of one axle, and of the other or the whole car";
  add("centre of gravity to front axle", "vehicle.front_axle", centre.front_axle, one_axle);
  add("centre of gravity to rear axle", "vehicle.rear_axle", centre.rear_axle, one_axle);
  add("wheelbase", "", dimensions.wheelbase, "");
  if (dimensions.track_width) {
    add("track width", "vehicle.track_width", dimensions.track_width, "");
    add("centre of gravity left of the middle", "", centre.lateral,
        "needs the load of one side, and of the other or the whole car", Share::meaningless);
  }
  const auto mass = mass_of(loads, weighings.scale);
  Finding weighed = as_finding("mass", "", mass.value_or(Measured{}), "kg");
  findings.values.push_back(mass ? weighed : undetermined(weighed, ""));
  if (centre.front_axle) findings.details["correlation"] = centre.correlation;
  if (centre.lateral && std::fabs(centre.lateral->value) >
                            0.05 * dimensions.track_width->value + 2.0 * centre.lateral->sigma)
    findings.warnings.push_back(
        found(diagnostics::kind("centre_off_side"), {},
              "the centre of gravity lies far to one side; the models assume it in the middle"));
  if (const auto line = contradiction(loads))
    findings.warnings.push_back(*line);
  else if (const auto warning = mass ? coarse(*mass) : std::nullopt)
    findings.warnings.push_back(*warning);
  const std::string config = options.config.empty() ? options.delivery.write : options.config;
  if (!config.empty()) {
    check_wheelbase(config, dimensions.wheelbase, findings);
    check_ends(config, centre, findings);
  }
  deliver(findings, options.delivery);
}

}  // namespace

void add_cog(Command identify) {
  const auto options = std::make_shared<Options>();
  Command method = identify.add_subcommand(
      "cog", "Measure the centre of gravity between the axles, with a scale and a tape measure");
  method.footer(
      R"(Put one axle on the scale and the other on a block of the same height, so that the car
stands level; then the other axle; then, for the lateral offset, the left wheels and the
right ones. Three times each, lifting the car in between. Steer straight ahead, tyres at
pressure, brakes off, so that nothing pushes the axles apart. Measure the wheelbase
between the centres of the wheels, on both sides, and the track width between the middles
of the tyres.

Precision: the distance of an axle is as precise as its load (1 g in 1 kg is 0.1 %) and the
wheelbase. A slope of the car moves it by height times slope: 0.2 mm for a height of 50 mm
and 0.25 degrees. The uncertainty allows for that by --height and --level. A gain error of
the scale cancels.

Examples:
  odom identify cog --front 976g --rear 2009g --scale-resolution 1g --wheelbase 260mm
  odom identify cog --front 0.976 --total 2.985 --left 1.51 --right 1.475 \
      --scale-resolution 1g --scale-sigma 2g --wheelbase 0.26 --track-width 0.16 \
      --config car.toml
  odom identify cog --front 9.57N --rear 19.7N --scale-sigma 0.05N --wheelbase 0.26 \
      --wheelbase-sigma 0.5mm --write car.toml)");
  add_scale_options(method, options->scale);
  method
      .add("--wheelbase", "LENGTH", options->wheelbase,
           "Distance between the centres of front and rear wheels [m], or 260mm")
      .required();
  method.add("--wheelbase-sigma", "LENGTH", options->wheelbase_sigma,
             "Standard uncertainty of the wheelbase; default: 1mm");
  method.add(
      "--track-width", "LENGTH", options->track_width,
      "Distance between the middles of left and right tyres [m], or 160mm; for the lateral offset");
  method.add("--track-width-sigma", "LENGTH", options->track_width_sigma,
             "Standard uncertainty of the track width; default: 1mm");
  add_level_options(method, options->level);
  method.add(
      "--config", "TOML", options->config,
      "Configuration of the car (TOML) to compare the wheelbase with; default: the one of --write");
  add_delivery(method, options->delivery);
  method.callback([options] { identify_cog(*options); });
}

}  // namespace odomd::tools
