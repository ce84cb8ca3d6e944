// odom identify stiffness: the cornering stiffness of both axles from filmed circles.
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/delivery.hpp"
#include "tools/identify/methods.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"
#include "tools/identify/stiffness/filmed_circles.hpp"
#include "tools/identify/stiffness/stiffness_findings.hpp"
#include "tools/identify/stiffness/stiffness_options.hpp"

namespace odomd::tools {
namespace {

// A default would be another car's.
void require_measured(const daemon::Config& config) {
  const toml::table table = toml::parse(config.text);
  for (const char* key : {"mass", "front_axle", "rear_axle"})
    if (!table["vehicle"][key])
      throw std::invalid_argument(fmt::format(
          "{}: [vehicle] {} is missing, which the side forces need; measure it: odom identify {}",
          config.file.string(), key, std::string_view{key} == "mass" ? "mass" : "cog"));
  for (const estimator::Source source : {estimator::Source::yaw_rate, estimator::Source::steering})
    if (!config.can.signals[static_cast<std::size_t>(source)].configured)
      throw std::invalid_argument(fmt::format(
          "{}: [can.signals] {} is missing, which the circles need", config.file.string(),
          estimator::source_names[static_cast<std::size_t>(source)]));
}

void identify_stiffness(const StiffnessOptions& options) {
  check(options);
  check(options.delivery);
  const MarkerPlaces places = marker_places(options);
  if (!options.plot.empty()) chart::check_picture(options.plot);
  const daemon::Config config = daemon::load_config(options.config);
  require_measured(config);

  FilmedCircles films = measure_films(options, config, places);
  check_circles(films.circles, config.vehicle.wheelbase());
  if (places.front.real() * places.rear.real() >= 0.0)
    films.warnings.push_back(found(diagnostics::kind("no_rear_marker"), {},
                                   "no marker lies behind the centre of gravity"));
  append(films.warnings, circle_warnings(films.circles));
  const CircleCar car = circle_car(options, config, places);
  const CorneringStiffness found = fit_stiffness(films.circles, car);
  const diagnostics::Diagnostics against = contradictions(films, found, car);
  if (against.empty()) require_slip(found);
  if (!options.plot.empty()) chart::write_picture(options.plot, draw_stiffness(found));
  if (!options.delivery.json) std::cout << circle_table(films, found) << '\n';
  deliver(stiffness_findings(films, found, against), options.delivery);
}

}  // namespace

void add_stiffness(Command identify) {
  auto options = std::make_shared<StiffnessOptions>();
  Command method = identify.add_subcommand("stiffness");
  describe_stiffness(method, *options);
  method.callback([options] { identify_stiffness(*options); });
}

}  // namespace odomd::tools
