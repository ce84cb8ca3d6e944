// odom identify stiffness: the cornering stiffness of both axles from filmed circles.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "daemon/config.hpp"
#include "tools/identify/circle_runs.hpp"
#include "tools/identify/cornering_stiffness.hpp"
#include "tools/identify/delivery.hpp"
#include "tools/identify/film_alignment.hpp"
#include "tools/identify/film_motion.hpp"
#include "tools/identify/marker_track.hpp"
#include "tools/identify/methods.hpp"
#include "tools/identify/quantity.hpp"
#include "tools/identify/stiffness_plot.hpp"
#include "tools/text.hpp"

namespace odomd::tools {
namespace {

constexpr double degrees = 57.29577951308232;

struct Arguments {
  std::vector<std::string> runs;
  std::string config;
  std::string front, rear;
  std::optional<double> metres_per_pixel;
  bool metres = false;
  bool y_down = false;
  std::optional<double> frames_per_second;
  std::optional<double> time_offset;
  std::string sigma_mass, sigma_axle, sigma_marker, sigma_scale = "0.3%";
  double rolling_resistance = 0.015;
  std::string plot;
  Delivery delivery;
};

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts{""};
  for (const char letter : text) {
    if (letter == ',')
      parts.emplace_back();
    else
      parts.back() += letter;
  }
  return parts;
}

Plane parse_place(const std::string& option, const std::string& text) {
  const std::vector<std::string> parts = parts_of(text);
  if (parts.size() != 2)
    throw std::invalid_argument(
        option + ": \"" + text +
        "\" is not X,Y from the centre of gravity, forward and to the left: 0.18,0 or 18cm,0");
  return {parse_quantity(parts[0], Dimension::length, option).value,
          parse_quantity(parts[1], Dimension::length, option).value};
}

void require_positive(const std::string& option, const std::optional<double>& value) {
  if (value && !(*value > 0.0 && std::isfinite(*value)))
    throw std::invalid_argument(option + ": must be greater than 0");
}

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

struct Films {
  std::vector<CircleRun> circles;
  std::vector<FilmAlignment> alignments;
  std::vector<std::string> names;
  std::vector<std::string> warnings;
};

void append(std::vector<std::string>& to, const std::vector<std::string>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

double given_or(const std::string& text, Dimension dimension, const std::string& option,
                double otherwise) {
  return text.empty() ? otherwise : parse_positive(text, dimension, option);
}

double sigma_marker_of(const Arguments& arguments, const MarkerPlaces& places) {
  return given_or(arguments.sigma_marker, Dimension::length, "--sigma-marker",
                  places.distance() / 300.0);
}

// Of a scale by the markers' distance, relative.
double sigma_by_distance(const Arguments& arguments, const MarkerPlaces& places) {
  return std::numbers::sqrt2 * sigma_marker_of(arguments, places) / places.distance();
}

// Of a scale that is given, relative.
double sigma_scale_of(const Arguments& arguments) {
  constexpr double largest = 0.1;
  const double sigma = parse_positive(arguments.sigma_scale, Dimension::pure, "--sigma-scale");
  if (sigma > largest)
    throw std::invalid_argument(fmt::format("--sigma-scale: {} is {:g} %; write per cent as {}%",
                                            arguments.sigma_scale, 100.0 * sigma,
                                            arguments.sigma_scale));
  return sigma;
}

void measure_film(const Arguments& arguments, const daemon::Config& config,
                  const MarkerPlaces& places, const std::string& run, Films& films) {
  const std::vector<std::string> files = parts_of(run);
  if (files.size() != 2 && files.size() != 3)
    throw std::invalid_argument("--run: \"" + run +
                                "\" is neither MARKERS,LOG nor FRONT,REAR,LOG (three files where "
                                "each marker has its own)");
  const FilmTime time{arguments.frames_per_second};
  const MarkerTrack track = files.size() == 2 ? read_marker_track(files[0], time)
                                              : read_marker_tracks(files[0], files[1], time);
  const bool given = arguments.metres || arguments.metres_per_pixel.has_value();
  const FilmScale scale{
      .from = given ? FilmScale::From::given : FilmScale::From::marker_distance,
      .metres_per_unit = arguments.metres ? 1.0 : arguments.metres_per_pixel.value_or(1.0),
      .ratio_sigma = std::hypot(sigma_scale_of(arguments), sigma_by_distance(arguments, places)),
      .axes = arguments.y_down ? ImageAxes::y_down : ImageAxes::y_up};
  FilmMotion motion = film_motion(track, places, scale);
  append(films.warnings, motion.warnings);

  const std::vector<std::string> logs{files.back()};
  const SignalLog log = read_signals(config, logs);
  append(films.warnings, log.warnings);
  const Series& gyro = log.of(estimator::Source::yaw_rate);
  if (log.of(estimator::Source::steering).empty())
    throw std::invalid_argument(files.back() + ": holds no steering angle; see odom dbc decode");
  FilmAlignment alignment;
  if (arguments.time_offset) {
    alignment = check_alignment(track.name, motion, gyro,
                                log.first_ns + std::llround(1e9 * *arguments.time_offset));
  } else {
    alignment = align_film(track.name, motion, gyro);
  }
  append(films.warnings, alignment.warnings);
  put_on_clock_of_log(alignment, motion);
  alignment.offset_ns -= log.first_ns;  // what people can read

  const std::size_t warned = films.warnings.size();
  std::vector<CircleRun> circles =
      measure_circles(track.name, motion, log, alignment.offset_ns + log.first_ns,
                      config.imu_position[1], films.warnings);
  if (circles.empty() && films.warnings.size() == warned)
    films.warnings.push_back(
        track.name + ": no steady circle in it; hold steering and speed for half a turn or more");
  films.circles.insert(films.circles.end(), circles.begin(), circles.end());
  films.alignments.push_back(alignment);
  films.names.push_back(track.name);
}

// What no fit could mend.
void check_directions(std::span<const CircleRun> circles) {
  std::size_t backwards = 0, against = 0;
  for (const CircleRun& run : circles) {
    if (std::cos(run.drift.value) < 0.3) ++backwards;
    if (run.steering.value * run.yaw_rate < 0.0) ++against;
  }
  if (2 * backwards > circles.size())
    throw std::invalid_argument(circles.front().film +
                                ": the car moves with its rear ahead: the markers are swapped "
                                "(exchange --front and --rear, "
                                "or the columns); circles in reverse do not serve");
  if (2 * against > circles.size())
    throw std::invalid_argument(
        circles.front().film +
        ": the car turns to the other side than it steers: mend the sign of [can.signals] steering "
        "(scale = -1.0); left is positive");
}

// Slope of the accelerometer over the film's v_x ψ̇: tells a wrong scale of the film.
void compare_accelerations(std::span<const CircleRun> circles, std::vector<std::string>& warnings) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (const CircleRun& run : circles) {
    if (!(run.accelerometer.sigma > 0.0)) continue;
    n += 1.0;
    x += run.lateral_accel;
    y += run.accelerometer.value;
    xx += run.lateral_accel * run.lateral_accel;
    xy += run.lateral_accel * run.accelerometer.value;
    yy += run.accelerometer.value * run.accelerometer.value;
  }
  const double spread = xx - x * x / std::max(n, 1.0);
  if (n < 4.0 || !(spread > 1.0)) return;
  const double slope = (xy - x * y / n) / spread;
  // Residuals of the line tell how well its slope is known.
  const double residual = std::max(yy - y * y / n - slope * slope * spread, 0.0);
  const double sigma = std::sqrt(residual / ((n - 2.0) * spread));
  if (std::abs(slope - 1.0) > std::max(0.02, 3.0 * sigma))
    warnings.push_back(fmt::format(
        "the accelerometer reads {:.1f} % of the film's lateral acceleration: check the film's "
        "scale and frame rate, and the unit of [can.signals] accel_y",
        100.0 * slope));
}

void warn_of_what_is_missing(std::span<const CircleRun> circles,
                             std::vector<std::string>& warnings) {
  const auto left =
      std::ranges::count_if(circles, [](const CircleRun& r) { return r.yaw_rate > 0; });
  if (left == 0 || left == std::ssize(circles))
    warnings.push_back(fmt::format(
        "all circles turn to the {}: the steering's offset and the angle of the markers cannot be "
        "told from slip; drive circles to the {} too",
        left == 0 ? "right" : "left", left == 0 ? "left" : "right"));
  const auto [slow, fast] = std::ranges::minmax_element(
      circles, {}, [](const CircleRun& r) { return std::abs(r.lateral_accel); });
  if (std::abs(slow->lateral_accel) > 0.5 * std::abs(fast->lateral_accel))
    warnings.emplace_back(
        "all circles are about as fast: slow ones (a quarter of the lateral acceleration) would "
        "tell the steering's scale and the markers' places from slip");
}

Finding stiffness_finding(const std::string& axle, const AxleStiffness& found) {
  Finding finding{.name = "cornering stiffness, " + axle,
                  .key = "vehicle.cornering_stiffness_" + axle,
                  .value = found.stiffness.value,
                  .sigma = found.stiffness.sigma,
                  .unit = "N/rad"};
  if (4.0 * finding.sigma > finding.value) {
    finding.determined = Determined::no;
    finding.remark = "too little slip for these markers; drive faster circles, and slow ones too";
  } else {
    finding.remark = fmt::format("slope at zero slip; within 10 % of it up to {:.1f}°",
                                 degrees * found.linear_range());
  }
  return finding;
}

void require_slip(const CorneringStiffness& found) {
  const auto undetermined = [](const AxleStiffness& axle) {
    return 4.0 * axle.stiffness.sigma > axle.stiffness.value;
  };
  if (!undetermined(found.front) || !undetermined(found.rear)) return;
  double slip = 0.0, sigma = 0.0;
  for (const AxlePoint& point : found.rear.points) {
    slip = std::max(slip, std::abs(point.force) / found.rear.stiffness.value);
    sigma = std::max(sigma, point.sigma);
  }
  throw std::invalid_argument(fmt::format(
      "the circles are too slow or too noisy: the largest slip angle is about {:.2f}°, of which "
      "the "
      "film resolves {:.2f}°; drive faster, or film sharper and closer, with the markers farther "
      "apart and their places better known",
      degrees * slip,
      degrees * std::max(sigma, slip * found.rear.stiffness.sigma / found.rear.stiffness.value)));
}

Findings findings_of(const Films& films, const CorneringStiffness& found) {
  Findings findings{.method = "stiffness",
                    .origin = fmt::format("{} filmed", counted(films.circles.size(), "circle")),
                    .warnings = films.warnings};
  findings.values.push_back(stiffness_finding("front", found.front));
  findings.values.push_back(stiffness_finding("rear", found.rear));
  findings.values.push_back({.name = "steering angle when straight ahead",
                             .value = found.steering_offset.value,
                             .sigma = found.steering_offset.sigma,
                             .unit = "rad",
                             .remark = "for the reader; fit tells it from a lap"});
  findings.values.push_back({.name = "steering angle reported per angle of the wheels",
                             .value = found.steering_scale.value,
                             .sigma = found.steering_scale.sigma,
                             .remark = "rolling resistance is in it"});
  for (std::size_t k = 0; k < films.names.size(); ++k)
    findings.values.push_back({.name = "begin of the film after the log",
                               .value = 1e-9 * static_cast<double>(films.alignments[k].offset_ns),
                               .sigma = films.alignments[k].sigma_s,
                               .unit = "s",
                               .remark = films.names[k]});
  for (const FilmAlignment& film : films.alignments)
    findings.details["films"].push_back({{"rate", film.rate}, {"rate_sigma", film.rate_sigma}});

  nlohmann::ordered_json& details = findings.details;
  details["scatter"] = found.scatter;
  details["linear_range"] = {{"front", found.front.linear_range()},
                             {"rear", found.rear.linear_range()}};
  details["grip"] = {{"front", found.front.grip}, {"rear", found.rear.grip}};
  for (std::size_t k = 0; k < films.circles.size(); ++k) {
    const CircleRun& run = films.circles[k];
    const AxlePoint& front = found.front.points[k];
    const AxlePoint& rear = found.rear.points[k];
    details["circles"].push_back({{"film", run.film},
                                  {"begin", 1e-9 * static_cast<double>(run.begin_ns)},
                                  {"end", 1e-9 * static_cast<double>(run.end_ns)},
                                  {"speed", run.speed},
                                  {"yaw_rate", run.yaw_rate},
                                  {"lateral_accel", run.lateral_accel},
                                  {"accelerometer", run.accelerometer.value},
                                  {"gyro", run.gyro.value},
                                  {"drift", run.drift.value},
                                  {"drift_sigma", run.drift.sigma},
                                  {"steering", run.steering.value},
                                  {"slip_front", front.slip},
                                  {"force_front", front.force},
                                  {"slip_rear", rear.slip},
                                  {"force_rear", rear.force},
                                  {"weight_front", front.weight},
                                  {"weight_rear", rear.weight}});
  }
  for (std::size_t axle = 0; axle < 2; ++axle) {
    const Finding& finding = findings.values[axle];
    if (finding.determined == Determined::yes && 2.0 * finding.sigma > 0.05 * finding.value)
      findings.warnings.push_back(fmt::format(
          "{}: 2 sigma are {:.0f} %, and 5 % can be had: drive faster circles, and slow ones too",
          finding.name, 200.0 * finding.sigma / finding.value));
  }
  return findings;
}

std::string circle_table(const Films& films, const CorneringStiffness& found) {
  Table table{.header = {"film", "from [s]", "turns", "v [m/s]", "R [m]", "a_y [m/s2]",
                         "slip front [deg]", "rear [deg]", ""}};
  for (std::size_t k = 0; k < films.circles.size(); ++k) {
    const CircleRun& run = films.circles[k];
    const bool kept = found.front.points[k].weight > 0.5 && found.rear.points[k].weight > 0.5;
    table.rows.push_back({run.film, fixed(1e-9 * static_cast<double>(run.begin_ns), 1),
                          fixed(run.turned / 6.283185307179586, 2), fixed(run.speed, 2),
                          fixed(run.radius(), 2), fixed(run.lateral_accel, 2),
                          fixed(degrees * found.front.points[k].slip, 2),
                          fixed(degrees * found.rear.points[k].slip, 2),
                          !found.in_range[k] ? "beyond the linear range"
                          : kept             ? ""
                                             : "off the curve"});
  }
  return table.text();
}

CircleCar circle_car(const Arguments& arguments, const daemon::Config& config,
                     const MarkerPlaces& places) {
  const double wheelbase = config.vehicle.wheelbase();
  const double mass = config.vehicle.mass;
  const double sigma_mass =
      given_or(arguments.sigma_mass, Dimension::mass, "--sigma-mass", 0.005 * mass);
  const double sigma_axle =
      given_or(arguments.sigma_axle, Dimension::length, "--sigma-axle", 0.004 * wheelbase);
  const double sigma_marker = sigma_marker_of(arguments, places);
  const double given = sigma_scale_of(arguments);
  const bool by_distance = !arguments.metres && !arguments.metres_per_pixel;
  return {.mass = {mass, sigma_mass},
          .front_axle = {config.vehicle.front_axle, sigma_axle},
          .rear_axle = {config.vehicle.rear_axle, sigma_axle},
          .rolling_resistance = {arguments.rolling_resistance, 0.01},
          .sigma_scale = by_distance ? sigma_by_distance(arguments, places) : given,
          .sigma_marker = sigma_marker,
          .marker_distance = places.distance()};
}

void identify_stiffness(const Arguments& arguments) {
  if (arguments.metres && arguments.metres_per_pixel)
    throw std::invalid_argument("--metres and --metres-per-pixel: give one of them");
  if (arguments.time_offset && arguments.runs.size() > 1)
    throw std::invalid_argument("--time-offset: is for a single --run");
  for (const auto& [option, value] : {std::pair{"--metres-per-pixel", arguments.metres_per_pixel},
                                      std::pair{"--fps", arguments.frames_per_second}})
    require_positive(option, value);
  if (!(arguments.rolling_resistance >= 0.0 && arguments.rolling_resistance < 0.3))
    throw std::invalid_argument("--rolling-resistance: must lie between 0 and 0.3");
  const MarkerPlaces places{parse_place("--front", arguments.front),
                            parse_place("--rear", arguments.rear)};
  if (!arguments.plot.empty()) chart::check_picture_name(arguments.plot);
  const daemon::Config config = daemon::load_config(arguments.config);
  require_measured(config);

  Films films;
  for (const std::string& run : arguments.runs) measure_film(arguments, config, places, run, films);
  if (films.circles.empty()) throw std::invalid_argument(films.warnings.back());
  check_directions(films.circles);
  warn_of_what_is_missing(films.circles, films.warnings);
  compare_accelerations(films.circles, films.warnings);
  const CorneringStiffness found =
      fit_stiffness(films.circles, circle_car(arguments, config, places));
  require_slip(found);
  if (!arguments.plot.empty()) chart::write_picture(arguments.plot, draw_stiffness(found));
  if (!arguments.delivery.json) std::cout << circle_table(films, found) << '\n';
  deliver(findings_of(films, found), arguments.delivery);
}

}  // namespace

void add_stiffness(Command identify) {
  auto arguments = std::make_shared<Arguments>();
  Command method = identify.add_subcommand(
      "stiffness", "Cornering stiffness of both axles, from circles filmed from above");
  method.footer(
      "The experiment: fix two markers to the roof, in one height, as far apart as the car "
      "allows;\n"
      "measure from the centre of gravity how far ahead and to the left each is. Film from above,\n"
      "the camera fixed and looking straight down, 50 frames a second or more, the bus being "
      "logged\n"
      "(candump -L). From standing, drive a circle at steady steering and speed, two turns; stop.\n"
      "Do so slowly, at medium speed and until the car slides a little, to the left and to the\n"
      "right: six circles at least, in one film or in several. Track both markers: odom identify\n"
      "track, or a program such as Tracker. Mass and axles must be in the configuration.\n"
      "\n"
      "The film gives the drift angle (path of the centre of gravity against the heading), speed,\n"
      "yaw rate and lateral acceleration; the log the steering angle. Where the film lies in the\n"
      "log is found from the yaw rates. The stiffness is the slope at zero slip of a curve that\n"
      "saturates, fitted to all circles. In the uncertainty are: the scatter of the circles, the\n"
      "markers' places, the film's scale, mass, axles, steering offset and scale, rolling\n"
      "resistance, and 1 % for what a bicycle leaves out of a car.\n"
      "\n"
      "Examples:\n"
      "  odom identify stiffness --config car.toml --front 0.18,0 --rear -0.12,0 --y-down \\\n"
      "    --run markers.csv,drive.log --plot tyres.svg --write car.toml\n"
      "  odom identify stiffness --config car.toml --front 0.18,0 --rear -0.12,0 --metres \\\n"
      "    --run left.csv,left.log --run right.csv,right.log\n"
      "  odom identify stiffness --config car.toml --front 0.18,0 --rear -0.12,0 \\\n"
      "    --run front.txt,rear.txt,drive.log");
  method
      .add_option("--run", arguments->runs,
                  "A film and its log: a table with t,x_front,y_front,x_rear,y_rear, or a table a "
                  "marker with t,x,y; repeatable")
      .type_name("MARKERS[,REAR],LOG")
      .required();
  method.add_option("--config", arguments->config, "The car's configuration")
      .type_name("FILE")
      .required();
  method
      .add_option("--front", arguments->front,
                  "Place of the front marker: ahead of the centre of gravity and to its left [m]")
      .type_name("X,Y")
      .required();
  method.add_option("--rear", arguments->rear, "... and of the rear marker: -0.12,0 [m]")
      .type_name("X,Y")
      .required();
  method
      .add_option("--metres-per-pixel", arguments->metres_per_pixel,
                  "Scale of the tracks; default: from the distance of the markers")
      .type_name("S");
  method.add_flag("--metres", arguments->metres, "The tracks are in metres");
  method.add_flag("--y-down", arguments->y_down,
                  "The tracks' y points down, as pixels do, or the film is mirrored");
  method
      .add_option("--fps", arguments->frames_per_second,
                  "The tracks' t counts frames of so many a second, as they were taken")
      .type_name("N");
  method
      .add_option("--time-offset", arguments->time_offset,
                  "The film's time 0 after the log's first frame [s]; default: found")
      .type_name("T");
  method.add_option("--plot", arguments->plot, "Picture of force over slip angle, .svg or .png")
      .type_name("FILE");
  const std::string known = "How well it was measured (one standard deviation)";
  method.add_option("--sigma-mass", arguments->sigma_mass, "Of the mass [kg]; default: 0.5 %")
      .type_name("S")
      .group(known);
  method
      .add_option("--sigma-axle", arguments->sigma_axle,
                  "Of front_axle and rear_axle, each [m]; default: 0.4 % of the wheelbase")
      .type_name("S")
      .group(known);
  method
      .add_option("--sigma-marker", arguments->sigma_marker,
                  "Of a marker's place on the car [m]; default: 1/300 of their distance")
      .type_name("S")
      .group(known);
  method
      .add_option("--sigma-scale", arguments->sigma_scale,
                  "Of a scale that is given, relative; default: 0.3%")
      .type_name("S")
      .group(known);
  method
      .add_option("--rolling-resistance", arguments->rolling_resistance,
                  "Coefficient, +- 0.01; default: 0.015")
      .type_name("C")
      .group(known);
  add_delivery(method, arguments->delivery);
  method.callback([arguments] { identify_stiffness(*arguments); });
}

}  // namespace odomd::tools
