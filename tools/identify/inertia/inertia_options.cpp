#include "tools/identify/inertia/inertia_options.hpp"

#include <cmath>
#include <stdexcept>

#include "tools/identify/common/quantity.hpp"
#include "tools/identify/weighing/scale_options.hpp"

namespace odomd::tools {
namespace {

constexpr Plausible between_cords{0.01, 10.0}, along_cords{0.05, 50.0};  // m

StopWatch stop_watch_of(const InertiaOptions& options, const std::vector<std::string>& times,
                        int swings, const std::string& prefix) {
  StopWatch watch;
  for (const std::string& text : times)
    watch.times.push_back(parse_positive(text, Dimension::time, prefix + "time"));
  if (swings < 1)
    throw std::invalid_argument(prefix + "swings is missing: how many full swings did each " +
                                prefix + "time take?");
  watch.swings = swings;
  watch.sigma = parse_not_negative(options.time_sigma, Dimension::time, "--time-sigma");
  watch.amplitude_begin = parse_not_negative(options.amplitude, Dimension::angle, "--amplitude");
  watch.amplitude_end =
      options.amplitude_end.empty()
          ? 0.5 * watch.amplitude_begin
          : parse_not_negative(options.amplitude_end, Dimension::angle, "--amplitude-end");
  return watch;
}

Measured mass_option(const std::string& text, const std::string& sigma, const std::string& option) {
  const double mass = parse_positive(text, Dimension::mass, option);
  // A kitchen scale.
  return {mass, sigma.empty() ? 0.002 * mass
                              : parse_not_negative(sigma, Dimension::mass, option + "-sigma")};
}

}  // namespace

Bifilar pendulum_of(const InertiaOptions& options) {
  Bifilar pendulum;
  const auto length = [](const std::string& text, const std::string& option, Plausible range) {
    return parse_plausible(text, Dimension::length, option, range);
  };
  pendulum.spacing_above = length(options.spacing, "--spacing", between_cords);
  pendulum.spacing_below = options.spacing_below.empty()
                               ? pendulum.spacing_above
                               : length(options.spacing_below, "--spacing-below", between_cords);
  pendulum.cord = length(options.cord, "--cord", along_cords);
  pendulum.offset = parse_not_negative(options.offset, Dimension::length, "--offset");
  check(pendulum);
  return pendulum;
}

Measured offset_square(const InertiaOptions& options, const Bifilar& pendulum) {
  const double sigma =
      options.offset_sigma.empty()
          ? 0.02 * pendulum.spacing_below
          : parse_not_negative(options.offset_sigma, Dimension::length, "--offset-sigma");
  // Only e² matters, whose mean is sigma² if e is unknown.
  const double variance = sigma * sigma;
  return {
      pendulum.offset * pendulum.offset + variance,
      std::sqrt(2.0 * variance * variance + 4.0 * pendulum.offset * pendulum.offset * variance)};
}

Measured mass_of_car(const InertiaOptions& options) {
  return mass_option(options.mass, options.mass_sigma, "--mass");
}

StopWatch watch_of_car(const InertiaOptions& options) {
  return stop_watch_of(options, options.times, options.swings, "--");
}

Platform platform_of(const InertiaOptions& options) {
  const bool weighed = !options.platform_mass.empty();
  const bool swung = !options.platform_times.empty();
  if (weighed != (swung || !options.platform_inertia.empty()))
    throw std::invalid_argument(
        weighed ? "--platform-mass alone does not give the platform's inertia; add "
                  "--platform-time and --platform-swings, or --platform-inertia"
                : "--platform-mass is missing: what does the platform weigh?");
  if (!weighed) return Platform::none;
  return swung ? Platform::swung : Platform::given;
}

Measured mass_of_platform(const InertiaOptions& options) {
  return mass_option(options.platform_mass, options.platform_mass_sigma, "--platform-mass");
}

StopWatch watch_of_platform(const InertiaOptions& options) {
  return stop_watch_of(options, options.platform_times, options.platform_swings, "--platform-");
}

Measured inertia_of_platform(const InertiaOptions& options) {
  const double inertia =
      parse_not_negative(options.platform_inertia, Dimension::pure, "--platform-inertia");
  return {inertia, options.platform_inertia_sigma.empty()
                       ? 0.05 * inertia
                       : parse_not_negative(options.platform_inertia_sigma, Dimension::pure,
                                            "--platform-inertia-sigma")};
}

void describe_inertia(Command command, InertiaOptions& options) {
  command.description("Measure the yaw inertia by swinging the car on two cords");
  command.footer(
      "Hang the car level by two thin cords of equal length, one on each side of its centre of\n"
      "gravity and equally far from it, vertical and parallel. It may stand on a light board:\n"
      "then weigh and swing the board alone, too. Turn the car by 10 to 20 degrees about the\n"
      "vertical, let it come to rest there, and let go without a push. Record its gyro for a\n"
      "minute, or time 20 full swings three times with a stop-watch, from one passage through the\n"
      "middle to the 20th after it in the same direction.\n"
      "Precision: J = m g D2 T2 / (16 pi2 L), so 1 % of the distance D counts 2 %, 1 % of the\n"
      "mass and of the cords' length L 1 %. Measure D to 0.5 mm at top and bottom, L under load "
      "and\n"
      "between the fixings. Long cords swing slowly and are easily measured: L at least 3 D.\n"
      "The amplitude of the swing and its decay are allowed for; with a stop-watch give\n"
      "--amplitude. An offset e of the centre of gravity along the line of the cords takes\n"
      "4 e2/D2 off: hang it so that both cords are equally tight. A tilt of 5 degrees takes 0.5 %\n"
      "off: level it to 2.\n"
      "A --csv has the columns t [s] and yaw_rate [rad/s].\n"
      "\n"
      "Examples:\n"
      "  odom identify inertia --mass 2.985 --spacing 200mm --cord 1.2m --config car.toml \\\n"
      "      --can swing/drive.log --write car.toml\n"
      "  odom identify inertia --mass 2985g --spacing 0.2 --cord 1.2 --swings 20 --time 42.81 \\\n"
      "      --time 42.95 --time 42.77 --amplitude 15deg --amplitude-end 8deg\n"
      "  odom identify inertia --mass 2.985 --spacing 0.2 --cord 1.2 --csv phone.csv \\\n"
      "      --platform-mass 310g --platform-swings 20 --platform-time 38.2");

  const auto text = [&command](const std::string& name, std::string& value, const std::string& help,
                               const std::string& type) {
    return command.add_option(name, value, help).type_name(type);
  };
  text("--mass", options.mass, "Mass of the car as it hangs, without the board [kg], or 2985g",
       "MASS")
      .required();
  text("--mass-sigma", options.mass_sigma, "Its standard uncertainty; default: 0.2 % of it",
       "MASS");
  text("--spacing", options.spacing, "Distance of the cords from each other [m], or 200mm",
       "LENGTH")
      .required();
  text("--spacing-below", options.spacing_below,
       "Distance of the cords at the car, if different; default: the same", "LENGTH");
  text("--spacing-sigma", options.spacing_sigma,
       "Standard uncertainty of each distance; default: 0.5mm", "LENGTH");
  text("--cord", options.cord, "Length of the cords between their fixings, under load [m]",
       "LENGTH")
      .required();
  text("--cord-sigma", options.cord_sigma, "Its standard uncertainty; default: 2mm", "LENGTH");
  text("--offset", options.offset,
       "Offset of the centre of gravity from the middle, along the line of the cords [m]; default: "
       "0",
       "LENGTH");
  text("--offset-sigma", options.offset_sigma,
       "Its standard uncertainty; default: 2 % of the distance", "LENGTH");
  text("--tilt", options.tilt, "Standard uncertainty of the level of the car [rad]; default: 2deg",
       "ANGLE");
  add_gravity_option(command, options.gravity);

  const std::string watch = "By stop-watch";
  command.add_option("--time", options.times, "Time of --swings swings [s]; repeat for each timing")
      .type_name("T")
      .one_each()
      .group(watch);
  command.add_option("--swings", options.swings, "Number of full swings in each timing")
      .type_name("N")
      .group(watch);
  text("--time-sigma", options.time_sigma,
       "Standard uncertainty of a timing, start and stop [s]; default: 0.15", "T")
      .group(watch);
  text("--amplitude", options.amplitude,
       "Amplitude of the first swing timed, from the middle [rad]; default: 10deg", "ANGLE")
      .group(watch);
  text("--amplitude-end", options.amplitude_end,
       "Amplitude of the last swing timed [rad]; default: half of the first", "ANGLE")
      .group(watch);

  const std::string log = "By a gyro's record";
  add_record_options(command, options.record, log);
  text("--clock-sigma", options.clock_sigma,
       "Standard uncertainty of the rate of the log's clock; default: 0.0001", "X")
      .group(log);
  text("--gyro-scale-sigma", options.gyro_scale_sigma,
       "Standard uncertainty of the gyro's scale, which gives the amplitude; default: 3%", "X")
      .group(log);

  const std::string board = "The board that the car stands on";
  text("--platform-mass", options.platform_mass, "Its mass [kg], or 310g", "MASS").group(board);
  text("--platform-mass-sigma", options.platform_mass_sigma,
       "Its standard uncertainty; default: 0.2 % of it", "MASS")
      .group(board);
  command
      .add_option(
          "--platform-time", options.platform_times,
          "Time of --platform-swings swings of the board alone [s], on the same cords; repeatable")
      .type_name("T")
      .one_each()
      .group(board);
  command
      .add_option("--platform-swings", options.platform_swings,
                  "Number of swings in each timing of the board alone")
      .type_name("N")
      .group(board);
  text("--platform-inertia", options.platform_inertia,
       "Its inertia [kg m2], instead of swinging it: a board of mass m has m (a2 + b2)/12", "J")
      .group(board);
  text("--platform-inertia-sigma", options.platform_inertia_sigma,
       "Its standard uncertainty; default: 5 % of it", "J")
      .group(board);
  add_delivery(command, options.delivery);
}

}  // namespace odomd::tools
