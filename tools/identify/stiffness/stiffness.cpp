// odom identify stiffness: the cornering stiffness of both axles from filmed circles.
#include <fmt/format.h>
#include <toml++/toml.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <ranges>
#include <stdexcept>
#include <utility>

#include "daemon/core/config.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/inputs.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

struct Options {
  std::vector<std::string> runs;
  std::string config;
  std::string front, rear;
  std::optional<double> metres_per_pixel;
  bool metres = false;
  bool y_down = false;
  std::string sigma_marker, sigma_scale = "0.3%";
  std::string plot;
  Delivery delivery;
  can::Damage damage = can::Damage::left_out;
};

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts;
  for (const auto part : text | std::views::split(','))
    parts.emplace_back(part.begin(), part.end());
  return parts;
}

Plane parse_place(const std::string& option, const std::string& text) {
  const std::vector<std::string> parts = parts_of(text);
  if (parts.size() != 2)
    refuse(
        "{}: \"{}\" is not X,Y from the centre of gravity, forward and to the left: 0.18,0 or "
        "18cm,0",
        option, text);
  return {parse_quantity(parts[0], Dimension::length, option),
          parse_quantity(parts[1], Dimension::length, option)};
}

// Relative sigma of a given scale.
double sigma_scale_of(const Options& options) {
  const double sigma = parse_positive(options.sigma_scale, Dimension::pure, "--sigma-scale");
  if (sigma > 0.1)
    refuse("--sigma-scale: {} is more than 10 %; a number without % is a fraction (0.003 is 0.3%)",
           options.sigma_scale);
  return sigma;
}

// Requires that mass and axles are configured: defaults would be those of another car.
void require_measured(const daemon::Config& config) {
  const toml::table table = toml::parse(config.text);
  for (const char* key : {"mass", "front_axle", "rear_axle"})
    if (!table["vehicle"][key])
      refuse(
          "{}: [vehicle] {} is missing, which the side forces need; measure it: odom identify {}",
          config.file.string(), key, std::string_view{key} == "mass" ? "mass" : "cog");
  for (const estimator::Source source : {estimator::Source::yaw_rate, estimator::Source::steering})
    if (!is_mapped(config, source))
      refuse("{}: [can.signals] {} is missing, which the circles need", config.file.string(),
             name_of(source));
}

CircleCar circle_car(const Options& options, const daemon::Config& config,
                     const MarkerPlaces& places) {
  const estimator::Vehicle& vehicle = config.vehicle;
  const auto measured = [&](const char* key, double value, double otherwise) {
    const auto noted = measured_in(options.config, key);
    return Measured{value, noted && noted->sigma > 0.0 ? noted->sigma : otherwise};
  };
  const double tape = 0.004 * vehicle.wheelbase();
  return {.mass = measured("vehicle.mass", vehicle.mass, 0.005 * vehicle.mass),
          .front_axle = measured("vehicle.front_axle", vehicle.front_axle, tape),
          .rear_axle = measured("vehicle.rear_axle", vehicle.rear_axle, tape),
          .rolling_resistance = {0.015, 0.01},
          .sigma_marker =
              options.sigma_marker.empty()
                  ? places.distance() / 300.0
                  : parse_positive(options.sigma_marker, Dimension::length, "--sigma-marker"),
          .marker_distance = places.distance()};
}

/// `run`: the film and log of one --run.
void measure_film(const Options& options, const daemon::Config& config, const MarkerPlaces& places,
                  const FilmScale& scale, const std::string& run, FilmedCircles& films) {
  const std::vector<std::string> files = parts_of(run);
  if (files.size() != 2) refuse("--run: \"{}\" is not MARKERS,LOG", run);
  const MarkerTrack track = read_marker_track(files[0]);
  const FilmMotion motion = film_motion(track, places, scale);
  append(films.warnings, motion.warnings);

  const SignalLog log = read_signals(config, {&files.back(), 1}, options.damage);
  append(films.warnings, log.warnings);
  const Series& gyro = log.need(estimator::Source::yaw_rate);
  (void)log.need(estimator::Source::steering);
  FilmAlignment alignment = align_film(track.name, motion, gyro);
  append(films.warnings, alignment.warnings);

  const std::size_t warned = films.warnings.size();
  std::vector<CircleRun> circles = measure_circles(track.name, motion, log, alignment.offset_ns,
                                                   config.imu_position[1], films.warnings);
  alignment.offset_ns -= log.first_ns;  // relative to the log's start, as shown to users
  if (circles.empty() && films.warnings.size() == warned)
    add_warning(films.warnings, tools::kind("no_circle"), track.name, "contains no steady circle");
  films.circles.insert(films.circles.end(), circles.begin(), circles.end());
  films.alignments.push_back(alignment);
}

Findings identify_stiffness(const Options& options) {
  if (options.metres && options.metres_per_pixel)
    refuse("--metres and --metres-per-pixel: give one of them");
  const MarkerPlaces places{parse_place("--front", options.front),
                            parse_place("--rear", options.rear)};
  if (!options.plot.empty()) chart::check_picture(options.plot);
  const daemon::Config config = daemon::load_config(options.config);
  require_measured(config);

  CircleCar car = circle_car(options, config, places);
  const double given = sigma_scale_of(options);
  const double by_markers = std::numbers::sqrt2 * car.sigma_marker / car.marker_distance;
  const FilmScale scale{.metres_per_unit = options.metres ? 1.0 : options.metres_per_pixel,
                        .ratio_sigma = std::hypot(given, by_markers),
                        .axes = options.y_down ? ImageAxes::y_down : ImageAxes::y_up};
  car.sigma_scale = scale.metres_per_unit ? given : by_markers;

  FilmedCircles films;
  for (const std::string& run : options.runs)
    measure_film(options, config, places, scale, run, films);
  if (films.circles.empty()) throw std::invalid_argument(text_of(films.warnings.back()));
  check_circles(films.circles, config.vehicle.wheelbase());
  if (places.front.real() * places.rear.real() >= 0.0)
    add_warning(films.warnings, tools::kind("no_rear_marker"), {},
                "no marker lies behind the centre of gravity");
  append(films.warnings, circle_warnings(films.circles));
  const CorneringStiffness found = fit_stiffness(films.circles, car);
  const diagnostics::Diagnostics against = contradictions(films, found, car);
  if (against.empty()) require_slip(found);
  if (!options.plot.empty()) chart::write_picture(options.plot, draw_stiffness(found));
  return stiffness_findings(films, found, against);
}

}  // namespace

void add_stiffness(Command identify) {
  const auto options = std::make_shared<Options>();
  const Command method = identify.add_subcommand(
      "stiffness", "Measure the cornering stiffness of both axles, from circles filmed from above");
  method.footer(
      R"(The experiment: fix two markers to the roof at the same height, as far apart as the car
allows. Measure how far ahead of the centre of gravity and to its left each one is. Take a
video from above, with a fixed camera that looks straight down, at 50 frames per second or
more, and log the bus (candump -L). From standstill, drive two turns of a circle with steady
steering and speed, and stop. Do so slowly, at medium speed, and until the car slides a
little, to the left and to the right: at least six circles, in one film or several. Track
both markers with odom identify track or another program. Mass and axles must be in the
configuration.

The film gives the sideslip angle (direction of travel relative to the heading), speed, yaw
rate and lateral acceleration; the log gives the steering angle. The yaw rates are used to
align film and log. The stiffness is the slope at zero slip of a saturating curve fitted to
all circles. The uncertainty includes the scatter of the circles, the positions of the
markers, the scale of the film, mass, axles, steering offset and scale, rolling resistance,
and 1 % for the simplifications of the single-track model.

Examples:
  odom identify stiffness --config car.toml --front 0.18,0 --rear -0.12,0 --y-down \
    --run markers.csv,drive.log --plot tyres.svg --write car.toml
  odom identify stiffness --config car.toml --front 0.18,0 --rear -0.12,0 --metres \
    --run left.csv,left.log --run right.csv,right.log)");
  method.add(
      "--run", "MARKERS,LOG", options->runs,
      "Film and its log: a CSV with t,x_front,y_front,x_rear,y_rear, t in seconds; repeatable",
      {required()});
  method.add("--config", "FILE", options->config, "Configuration of the car (TOML)", {required()});
  method.add("--front", "X,Y", options->front,
             "Position of the front marker: ahead of the centre of gravity and to its left [m]",
             {required()});
  method.add("--rear", "X,Y", options->rear, "Position of the rear marker, likewise: -0.12,0 [m]",
             {required()});
  method.add("--metres-per-pixel", "S", options->metres_per_pixel,
             "Scale of the tracks [m/px]; default: from the markers' distance", {positive()});
  method.add_flag("--metres", options->metres, "The tracks are in metres");
  method.add_flag("--y-down", options->y_down,
                  "The y axis of the tracks points down, as in pixels, or the film is mirrored");
  method.add("--plot", "FILE", options->plot, "Picture of force over slip angle, .svg or .png");
  const Command known = method.group("Uncertainty of the measurements");
  known.add("--sigma-marker", "S", options->sigma_marker,
            "Standard uncertainty of a marker's position on the car [m]; default: 1/300 of their "
            "distance");
  known.add("--sigma-scale", "S", options->sigma_scale,
            "Standard uncertainty of a given scale, relative; default: 0.3%");
  add_delivery(method, options, identify_stiffness);
  add_strict(method, options->damage);
}

}  // namespace odomd::tools
