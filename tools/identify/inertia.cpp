// odom identify inertia: the yaw inertia, by the period in which the car turns on two cords.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "tools/identify/bifilar.hpp"
#include "tools/identify/config_patch.hpp"
#include "tools/identify/delivery.hpp"
#include "tools/identify/methods.hpp"
#include "tools/identify/propagation.hpp"
#include "tools/identify/quantity.hpp"
#include "tools/identify/record.hpp"
#include "tools/identify/scale_options.hpp"
#include "tools/identify/swing_fit.hpp"
#include "tools/identify/swing_timing.hpp"
#include "tools/text.hpp"

namespace odomd::tools {
namespace {

using std::numbers::pi;

/// One swing: on a log, or by stop-watch.
struct SwingOptions {
  RecordOptions record;
  std::vector<std::string> times;
  int swings = 0;
};

struct Options {
  SwingOptions car;
  std::vector<std::string> platform_times;
  int platform_swings = 0;
  std::string platform_mass, platform_mass_sigma, platform_inertia, platform_inertia_sigma;
  std::string mass, mass_sigma;
  std::string spacing, spacing_below, spacing_sigma = "0.5mm";
  std::string cord, cord_sigma = "2mm";
  std::string offset = "0", offset_sigma;
  std::string tilt = "2deg";
  std::string amplitude = "10deg", amplitude_end;
  std::string time_sigma = "0.15";
  std::string clock_sigma = "0.0001";
  std::string gyro_scale_sigma = "3%";
  std::string gravity;
  Delivery delivery;
};

constexpr Plausible between_cords{0.01, 10.0}, along_cords{0.05, 50.0};  // m

Bifilar pendulum_of(const Options& options) {
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

StopWatch stop_watch_of(const Options& options, const std::vector<std::string>& times, int swings,
                        const std::string& prefix) {
  StopWatch watch;
  for (const std::string& text : times)
    watch.times.push_back(parse_positive(text, Dimension::time, prefix + "time"));
  if (swings < 1)
    throw std::invalid_argument(prefix + "swings is missing: how many swings to and fro did each " +
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

struct Period {
  Measured small;  ///< of small swings [s]
  std::string origin;
};

/// From the record: the clock's rate, and what a gyro that over-reads makes of the amplitude, come
/// on top of what the fit knows.
Period period_of_record(const Options& options, const Bifilar& pendulum, Findings& findings) {
  const Series yaw_rate = read_yaw_rate(options.car.record, findings.warnings);
  const SwingFit fit = fit_swing(yaw_rate, pendulum, name_of(options.car.record));
  for (const std::string& warning : fit.warnings) findings.warnings.push_back(warning);
  const double radius_squared = inertia_of(pendulum, 1.0, 9.81, fit.period);  // J/m
  const double mean_square =
      0.5 * (fit.amplitude_begin * fit.amplitude_begin + fit.amplitude_end * fit.amplitude_end);
  const double correction = lengthening(pendulum, radius_squared, std::sqrt(mean_square)) - 1.0;
  const double scale =
      parse_not_negative(options.gyro_scale_sigma, Dimension::pure, "--gyro-scale-sigma");
  const double clock = parse_not_negative(options.clock_sigma, Dimension::pure, "--clock-sigma");
  findings.details["swing"] = {{"swings", fit.swings},
                               {"amplitude_begin", fit.amplitude_begin},
                               {"amplitude_end", fit.amplitude_end},
                               {"damping_ratio", fit.damping_ratio},
                               {"gyro_bias", fit.gyro_bias},
                               {"residual_rms", fit.residual_rms},
                               {"lengthening", correction}};
  const double sigma =
      std::hypot(fit.period_sigma, fit.period * clock, fit.period * 2.0 * scale * correction);
  return {{fit.period, sigma}, fmt::format("gyro, {:.0f} swings", fit.swings)};
}

Period period_of_watch(const StopWatch& watch, const Bifilar& pendulum, Findings& findings) {
  const TimedSwing swing = small_period_of(watch, pendulum);
  for (const std::string& warning : swing.warnings) findings.warnings.push_back(warning);
  findings.details["swing"] = {{"swings", watch.swings},
                               {"timings", watch.times.size()},
                               {"lengthening", swing.lengthening}};
  return {swing.period, fmt::format("stop-watch, {} of {} swings",
                                    counted(watch.times.size(), "timing"), watch.swings)};
}

Measured mass_option(const std::string& text, const std::string& sigma, const std::string& option) {
  const double mass = parse_positive(text, Dimension::mass, option);
  // A kitchen scale.
  return {mass, sigma.empty() ? 0.002 * mass
                              : parse_not_negative(sigma, Dimension::mass, option + "-sigma")};
}

/// J / (m l_v l_h) of cars lies about 1; of one whose passages were counted it is a quarter.
void compare_with_axles(const std::string& file, double mass, double inertia, Findings& findings) {
  const auto front = number_in(file, "vehicle.front_axle");
  const auto rear = number_in(file, "vehicle.rear_axle");
  if (!front || !rear || !(*front * *rear > 0.0)) return;
  const double ratio = inertia / (mass * *front * *rear);
  constexpr double least = 0.4, most = 2.0;
  if (ratio > least && ratio < most) return;
  findings.warnings.push_back(fmt::format(
      "the yaw inertia is {:.2g} times m l_v l_h by the axles in {}, and cars have {} to {}: "
      "passages counted in the place of swings to and fro, or a length in another unit?",
      ratio, file, least, most));
}

void identify_inertia(const Options& options) {
  Findings findings{.method = "inertia"};
  const Bifilar pendulum = pendulum_of(options);
  const bool recorded = is_given(options.car.record);
  if (recorded == !options.car.times.empty())
    throw std::invalid_argument(
        recorded ? "--time and a record: which of them? Give one"
                 : "give --time and --swings, --csv, or --config and --can; odom identify inertia "
                   "--help tells what each is");
  const Period period =
      recorded
          ? period_of_record(options, pendulum, findings)
          : period_of_watch(stop_watch_of(options, options.car.times, options.car.swings, "--"),
                            pendulum, findings);
  const Measured mass = mass_option(options.mass, options.mass_sigma, "--mass");
  check_size(pendulum, period.small.value);
  check_mass(pendulum, period.small.value, mass.value);

  // Off the midst by e: only e² counts, which is sigma² on the average where e is unknown.
  const double offset_sigma =
      options.offset_sigma.empty()
          ? 0.02 * pendulum.spacing_below
          : parse_not_negative(options.offset_sigma, Dimension::length, "--offset-sigma");
  const double variance = offset_sigma * offset_sigma;
  const Measured offset_square{
      pendulum.offset * pendulum.offset + variance,
      std::sqrt(2.0 * variance * variance + 4.0 * pendulum.offset * pendulum.offset * variance)};

  const double tape =
      parse_not_negative(options.spacing_sigma, Dimension::length, "--spacing-sigma");
  const double tilt = parse_not_negative(options.tilt, Dimension::angle, "--tilt");
  std::vector<Input> inputs{
      {"mass", mass},
      {"gravity", gravity_of(options.gravity)},
      {"distance of the cords above", {pendulum.spacing_above, tape}},
      {"distance of the cords below", {pendulum.spacing_below, tape}},
      {"length of the cords",
       {pendulum.cord, parse_not_negative(options.cord_sigma, Dimension::length, "--cord-sigma")}},
      {"period", period.small},
      {"offset of the centre of gravity", offset_square},
      // Tilted by τ it swings about another axis: J cos²τ + J_x sin²τ, and a car's J_x is a third.
      {"tilt of the car", {0.0, 0.7 * tilt * tilt}}};
  const std::size_t own = inputs.size();

  const bool platform = !options.platform_mass.empty();
  const bool platform_swung = !options.platform_times.empty();
  if (platform != (platform_swung || !options.platform_inertia.empty()))
    throw std::invalid_argument(
        platform ? "--platform-mass alone does not tell the platform's inertia; give its own "
                   "--platform-time and --platform-swings, or --platform-inertia"
                 : "--platform-mass is missing: what does the platform weigh?");
  if (platform)
    inputs.push_back(
        {"mass of the platform",
         mass_option(options.platform_mass, options.platform_mass_sigma, "--platform-mass")});
  if (platform_swung) {
    const StopWatch watch =
        stop_watch_of(options, options.platform_times, options.platform_swings, "--platform-");
    inputs.push_back({"period of the platform", small_period_of(watch, pendulum).period});
  } else if (platform) {
    const double inertia =
        parse_not_negative(options.platform_inertia, Dimension::pure, "--platform-inertia");
    inputs.push_back(
        {"inertia of the platform",
         {inertia, options.platform_inertia_sigma.empty()
                       ? 0.05 * inertia
                       : parse_not_negative(options.platform_inertia_sigma, Dimension::pure,
                                            "--platform-inertia-sigma")}});
  }

  // J = (m + m_p) g p T² / (4 π² h) - J_p
  const Propagated inertia = propagate(inputs, [&](const std::vector<double>& x) {
    Bifilar hung{.spacing_above = x[2],
                 .spacing_below = x[3],
                 .cord = x[4],
                 .offset = std::sqrt(std::fmax(x[6], 0.0))};
    const double carried = platform ? x[own] : 0.0;
    const double whole = inertia_of(hung, x[0] + carried, x[1], x[5]) * (1.0 + x[7]);
    if (!platform) return whole;
    hung.offset = 0.0;  // of the platform alone
    return whole - (platform_swung ? inertia_of(hung, carried, x[1], x[own + 1]) : x[own + 1]);
  });
  if (!(inertia.result.value > 0.0))
    throw std::invalid_argument("the platform has more inertia than car and platform together");

  findings.origin = "bifilar pendulum, " + period.origin;
  findings.values.push_back({.name = "yaw inertia",
                             .key = "vehicle.yaw_inertia",
                             .value = inertia.result.value,
                             .sigma = inertia.result.sigma,
                             .unit = "kg m2",
                             .remark = largest_contributions(inertia)});
  findings.values.push_back({.name = "period of small swings",
                             .value = period.small.value,
                             .sigma = period.small.sigma,
                             .unit = "s"});
  for (const Contribution& part : inertia.contributions)
    findings.details["contributions"][part.name] = part.sigma;
  if (inertia.result.sigma > 0.01 * inertia.result.value)
    findings.warnings.push_back("2 sigma are more than 2 %: " + largest_contributions(inertia));
  const std::string& config =
      options.delivery.write.empty() ? options.car.record.config : options.delivery.write;
  if (!config.empty()) compare_with_axles(config, mass.value, inertia.result.value, findings);
  deliver(findings, options.delivery);
}

}  // namespace

void add_inertia(Command identify) {
  const auto options = std::make_shared<Options>();
  Command method =
      identify.add_subcommand("inertia", "The yaw inertia, by the swing of the car on two cords");
  method.footer(
      "Hang the car level by two thin cords of equal length, one on each side of its centre of\n"
      "gravity and equally far from it, straight up and parallel. A light board that it stands on\n"
      "will do: weigh and swing the board alone, too. Turn the car by 10 to 20 degrees about the\n"
      "vertical, let it come to rest there, and let go without a push. Record its gyro for a\n"
      "minute, or stop the time of 20 swings to and fro three times, from one passage through the\n"
      "middle to the 20th after it in the same direction.\n"
      "How exactly: J = m g D2 T2 / (16 pi2 L), so that 1 % of the distance D counts 2 %, of the\n"
      "mass and of the cords' length L 1 %. Measure D to 0.5 mm above and below, L under load and\n"
      "between the very fixings. Long cords swing slowly and are easily measured: L at least 3 D.\n"
      "How far the swing went, and that it dies away, is allowed for; by stop-watch give\n"
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

  const auto text = [&method](const std::string& name, std::string& value, const std::string& help,
                              const std::string& type) {
    return method.add_option(name, value, help).type_name(type);
  };
  text("--mass", options->mass, "Of the car as it hangs, without the board [kg], or 2985g", "MASS")
      .required();
  text("--mass-sigma", options->mass_sigma, "Its standard uncertainty; default: 0.2 % of it",
       "MASS");
  text("--spacing", options->spacing, "Distance of the cords from each other [m], or 200mm",
       "LENGTH")
      .required();
  text("--spacing-below", options->spacing_below,
       "... at the car, where it is another; default: the same", "LENGTH");
  text("--spacing-sigma", options->spacing_sigma,
       "Standard uncertainty above, and below; default: 0.5mm", "LENGTH");
  text("--cord", options->cord, "Length of the cords between their fixings, under load [m]",
       "LENGTH")
      .required();
  text("--cord-sigma", options->cord_sigma, "Its standard uncertainty; default: 2mm", "LENGTH");
  text("--offset", options->offset,
       "Of the centre of gravity from the midst, along the line of the cords [m]; default: 0",
       "LENGTH");
  text("--offset-sigma", options->offset_sigma,
       "Its standard uncertainty; default: 2 % of the distance", "LENGTH");
  text("--tilt", options->tilt, "How level it hung, standard uncertainty [rad]; default: 2deg",
       "ANGLE");
  add_gravity_option(method, options->gravity);

  const std::string watch = "By stop-watch";
  method
      .add_option("--time", options->car.times,
                  "What --swings swings took [s]; repeat for each timing")
      .type_name("T")
      .one_each()
      .group(watch);
  method.add_option("--swings", options->car.swings, "How many swings to and fro, in each timing")
      .type_name("N")
      .group(watch);
  text("--time-sigma", options->time_sigma,
       "Standard uncertainty of a timing, start and stop [s]; default: 0.15", "T")
      .group(watch);
  text("--amplitude", options->amplitude,
       "Of the first swing timed, from the middle [rad]; default: 10deg", "ANGLE")
      .group(watch);
  text("--amplitude-end", options->amplitude_end,
       "Of the last swing timed [rad]; default: half of the first", "ANGLE")
      .group(watch);

  const std::string log = "By a gyro's record";
  add_record_options(method, options->car.record, log);
  text("--clock-sigma", options->clock_sigma,
       "Standard uncertainty of the rate of the log's clock; default: 0.0001", "X")
      .group(log);
  text("--gyro-scale-sigma", options->gyro_scale_sigma,
       "... of the gyro's scale, which the amplitude comes from; default: 3%", "X")
      .group(log);

  const std::string board = "The board that the car stands on";
  text("--platform-mass", options->platform_mass, "Its mass [kg], or 310g", "MASS").group(board);
  text("--platform-mass-sigma", options->platform_mass_sigma,
       "Its standard uncertainty; default: 0.2 % of it", "MASS")
      .group(board);
  method
      .add_option("--platform-time", options->platform_times,
                  "What --platform-swings swings of it alone took [s], on the same cords; repeat")
      .type_name("T")
      .one_each()
      .group(board);
  method
      .add_option("--platform-swings", options->platform_swings,
                  "How many swings, in each timing of it alone")
      .type_name("N")
      .group(board);
  text("--platform-inertia", options->platform_inertia,
       "Its inertia [kg m2], where it need not be swung: a board of mass m has m (a2 + b2)/12", "J")
      .group(board);
  text("--platform-inertia-sigma", options->platform_inertia_sigma,
       "Its standard uncertainty; default: 5 % of it", "J")
      .group(board);
  add_delivery(method, options->delivery);
  method.callback([options] { identify_inertia(*options); });
}

}  // namespace odomd::tools
