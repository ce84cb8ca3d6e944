// odom identify inertia: the yaw inertia, from the period of the car's swings on two cords.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/quantity.hpp"
#include "tools/identify/common/record.hpp"
#include "tools/identify/common/refuse.hpp"
#include "tools/identify/inertia/bifilar.hpp"
#include "tools/identify/inertia/propagation.hpp"
#include "tools/identify/methods.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

struct Options {
  RecordOptions record;
  std::vector<std::string> times;
  int swings = 0;
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

struct Period {
  Measured small;  ///< period of small swings [s]
  std::string origin;
};

Bifilar pendulum_of(const Options& options) {
  constexpr Plausible between_cords{0.01, 10.0}, along_cords{0.05, 50.0};  // m
  const auto length = [](const std::string& text, const std::string& option, Plausible range) {
    return parse_plausible(text, Dimension::length, option, range);
  };
  const std::string& below =
      options.spacing_below.empty() ? options.spacing : options.spacing_below;
  const Bifilar pendulum{
      .spacing_above = length(options.spacing, "--spacing", between_cords),
      .spacing_below = length(below, "--spacing-below", between_cords),
      .cord = length(options.cord, "--cord", along_cords),
      .offset = parse_not_negative(options.offset, Dimension::length, "--offset")};
  check(pendulum);
  return pendulum;
}

StopWatch watch_of(const Options& options, const std::vector<std::string>& times, int swings,
                   const std::string& prefix) {
  StopWatch watch{.swings = swings};
  for (const std::string& text : times)
    watch.times.push_back(parse_positive(text, Dimension::time, prefix + "time"));
  if (swings < 1)
    throw std::invalid_argument(prefix + "swings is missing: how many full swings did each " +
                                prefix + "time take?");
  watch.sigma = parse_not_negative(options.time_sigma, Dimension::time, "--time-sigma");
  watch.amplitude_begin = parse_not_negative(options.amplitude, Dimension::angle, "--amplitude");
  watch.amplitude_end = parse_or(0.5 * watch.amplitude_begin, options.amplitude_end,
                                 Dimension::angle, "--amplitude-end");
  return watch;
}

Measured mass_of(const std::string& text, const std::string& sigma, const std::string& option) {
  const double mass = parse_positive(text, Dimension::mass, option);
  // The default suits a kitchen scale.
  return {mass, parse_or(0.002 * mass, sigma, Dimension::mass, option + "-sigma")};
}

/// The mass as given, or from the configuration.
Measured mass_of_car(const Options& options, const std::string& config) {
  if (!options.mass.empty()) return mass_of(options.mass, options.mass_sigma, "--mass");
  auto mass = config.empty() ? std::nullopt : measured_in(config, "vehicle.mass");
  if (!mass) refuse("the mass is missing; give --mass, or a --config with [vehicle] mass");
  if (mass->sigma == 0.0) mass->sigma = 0.002 * mass->value;
  return *mass;
}

/// The period from the record. Its uncertainty combines those of the fit, of the clock's rate, and
/// of the amplitude (the gyro's scale).
Period period_of_record(const Options& options, const Bifilar& pendulum, Findings& findings) {
  const Series yaw_rate = read_yaw_rate(options.record, findings.warnings);
  const SwingFit fit = fit_swing(yaw_rate, pendulum, name_of(options.record));
  append(findings.warnings, fit.warnings);
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
  append(findings.warnings, swing.warnings);
  findings.details["swing"] = {{"swings", watch.swings},
                               {"timings", watch.times.size()},
                               {"lengthening", swing.lengthening}};
  return {swing.period, fmt::format("stop-watch, {} of {} swings",
                                    counted(watch.times.size(), "timing"), watch.swings)};
}

Period period_of_car(const Options& options, const Bifilar& pendulum, Findings& findings) {
  if (is_given(options.record)) return period_of_record(options, pendulum, findings);
  if (options.times.empty())
    refuse(
        "give --time and --swings, --csv, or --config and --can; odom identify inertia --help "
        "explains each");
  return period_of_watch(watch_of(options, options.times, options.swings, "--"), pendulum,
                         findings);
}

/// A platform that carries the car: its mass, and its inertia or its period alone on the cords.
struct Platform {
  Measured mass, inertia, period;

  [[nodiscard]] bool is_swung() const { return period.value > 0.0; }
};

std::optional<Platform> platform_of(const Options& options, const Bifilar& pendulum) {
  const bool weighed = !options.platform_mass.empty(), swung = !options.platform_times.empty();
  if (weighed != (swung || !options.platform_inertia.empty()))
    throw std::invalid_argument(
        weighed ? "--platform-mass alone does not give the platform's inertia; add "
                  "--platform-time and --platform-swings, or --platform-inertia"
                : "--platform-mass is missing: what does the platform weigh?");
  if (!weighed) return std::nullopt;
  Platform platform{
      .mass = mass_of(options.platform_mass, options.platform_mass_sigma, "--platform-mass")};
  if (swung) {
    const StopWatch watch =
        watch_of(options, options.platform_times, options.platform_swings, "--platform-");
    platform.period = small_period_of(watch, pendulum).period;
  } else {
    const double inertia =
        parse_not_negative(options.platform_inertia, Dimension::pure, "--platform-inertia");
    platform.inertia = {inertia, parse_or(0.05 * inertia, options.platform_inertia_sigma,
                                          Dimension::pure, "--platform-inertia-sigma")};
  }
  return platform;
}

// J = (m + m_p) g p T² / (4 π² h) - J_p
Propagated inertia_on_cords(const Options& options, const Bifilar& pendulum, Measured mass,
                            Measured period) {
  const double tape =
      parse_not_negative(options.spacing_sigma, Dimension::length, "--spacing-sigma");
  const double level = parse_not_negative(options.tilt, Dimension::angle, "--tilt");
  // Only e² matters; its mean is sigma² if e is unknown.
  const double off2 = pendulum.offset * pendulum.offset;
  const double variance = std::pow(parse_or(0.02 * pendulum.spacing_below, options.offset_sigma,
                                            Dimension::length, "--offset-sigma"),
                                   2);
  Measured gravity = gravity_of(options.gravity);
  Measured above{pendulum.spacing_above, tape}, below{pendulum.spacing_below, tape};
  Measured cord{pendulum.cord,
                parse_not_negative(options.cord_sigma, Dimension::length, "--cord-sigma")};
  Measured offset2{off2 + variance, std::sqrt(2.0 * variance * variance + 4.0 * off2 * variance)};
  // Tilted by τ it swings about another axis: J cos²τ + J_x sin²τ, where a car's J_x is about a
  // third of J.
  Measured tilt{0.0, 0.7 * level * level};
  std::vector<Input> inputs{{"mass", &mass},
                            {"gravity", &gravity},
                            {"distance of the cords above", &above},
                            {"distance of the cords below", &below},
                            {"length of the cords", &cord},
                            {"period", &period},
                            {"offset of the centre of gravity", &offset2},
                            {"tilt of the car", &tilt}};
  std::optional<Platform> platform = platform_of(options, pendulum);
  if (platform) {
    inputs.push_back({"mass of the platform", &platform->mass});
    inputs.push_back(platform->is_swung() ? Input{"period of the platform", &platform->period}
                                          : Input{"inertia of the platform", &platform->inertia});
  }
  Propagated inertia = propagate(inputs, [&] {
    Bifilar hung{.spacing_above = above.value,
                 .spacing_below = below.value,
                 .cord = cord.value,
                 .offset = std::sqrt(std::fmax(offset2.value, 0.0))};
    const double carried = platform ? platform->mass.value : 0.0;
    const double whole =
        inertia_of(hung, mass.value + carried, gravity.value, period.value) * (1.0 + tilt.value);
    if (!platform) return whole;
    hung.offset = 0.0;  // the platform hangs in the middle
    return whole - (platform->is_swung()
                        ? inertia_of(hung, carried, gravity.value, platform->period.value)
                        : platform->inertia.value);
  });
  if (!(inertia.result.value > 0.0))
    refuse("the platform has more inertia than car and platform together");
  return inertia;
}

Findings identify_inertia(const Options& options) {
  Findings findings{.method = "inertia"};
  const Bifilar pendulum = pendulum_of(options);
  const Period period = period_of_car(options, pendulum, findings);
  const std::string& config =
      options.record.config.empty() ? options.delivery.write : options.record.config;
  const Measured mass = mass_of_car(options, config);
  check_size(pendulum, period.small.value);
  check_mass(pendulum, period.small.value, mass.value);
  const Propagated inertia = inertia_on_cords(options, pendulum, mass, period.small);

  findings.origin = "bifilar pendulum, " + period.origin;
  findings.values = {as_finding("yaw inertia", "vehicle.yaw_inertia", inertia.result, "kg m2",
                                largest_contributions(inertia)),
                     as_finding("period of small swings", "", period.small, "s")};
  for (const Contribution& part : inertia.contributions)
    findings.details["contributions"][part.name] = part.sigma;
  if (!tools::kind("inertia_uncertain")
           .limits.hold(2.0 * inertia.result.sigma / inertia.result.value))
    findings.warnings.push_back(
        found(tools::kind("inertia_uncertain"), {},
              "2 sigma is more than 2 %: " + largest_contributions(inertia)));
  if (!config.empty())
    append(findings.warnings, check_inertia(config, mass.value, inertia.result.value));
  return findings;
}

void describe_inertia(Command command, Options& options) {
  command.description("Measure the yaw inertia by swinging the car on two cords");
  command.footer(
      R"(Hang the car level by two thin cords of equal length, one on each side of its centre of
gravity and equally far from it, vertical and parallel. It may stand on a light board:
then weigh and swing the board alone, too. Turn the car by 10 to 20 degrees about the
vertical, let it come to rest there, and let go without a push. Record its gyro for a
minute, or time 20 full swings three times with a stop-watch, from one passage through the
middle to the 20th after it in the same direction.

Precision: the inertia is J = m g D^2 T^2 / (16 pi^2 L), with the distance D of the cords,
their length L and the period T. An error of 1 % in D makes 2 % in J, an error of 1 % in m
or L makes 1 %. Measure D to 0.5 mm at top and bottom, and L under load and between the
fixings. Make L at least 3 D: long cords swing slowly and are measured more precisely.
The amplitude and its decay are corrected for; with a stop-watch give --amplitude. An
offset e of the centre of gravity along the line of the cords reduces J by the share
4 e^2/D^2: hang the car so that both cords are equally tight. A tilt of 5 degrees reduces J
by 0.5 %: level the car to 2 degrees.

Examples:
  odom identify inertia --measured swing/measured.json --config car.toml \
      --can swing/drive.log --write car.toml
  odom identify inertia --mass 2985g --spacing 0.2 --cord 1.2 --swings 20 --time 42.81 \
      --time 42.95 --time 42.77 --amplitude 15deg --amplitude-end 8deg
  odom identify inertia --mass 2.985 --spacing 0.2 --cord 1.2 --csv phone.csv \
      --platform-mass 310g --platform-swings 20 --platform-time 38.2)");

  add_measured_option(command);
  command.add("--mass", "MASS", options.mass,
              "Mass of the car as it hangs, without the board [kg], or 2985g; default: the one of "
              "--config or --write, with the uncertainty in its note");
  command.add("--mass-sigma", "MASS", options.mass_sigma,
              "Standard uncertainty of the mass; default: 0.2 % of it");
  command.add("--spacing", "LENGTH", options.spacing,
              "Distance of the cords from each other [m], or 200mm", {required()});
  command.add("--spacing-below", "LENGTH", options.spacing_below,
              "Distance of the cords at the car, if different; default: the same");
  command.add("--spacing-sigma", "LENGTH", options.spacing_sigma,
              "Standard uncertainty of each distance of the cords; default: 0.5mm");
  command.add("--cord", "LENGTH", options.cord,
              "Length of the cords between their fixings, under load [m]", {required()});
  command.add("--cord-sigma", "LENGTH", options.cord_sigma,
              "Standard uncertainty of the cords' length; default: 2mm");
  command.add("--offset", "LENGTH", options.offset,
              "Offset of the centre of gravity from the middle, along the line of the cords [m]; "
              "default: 0");
  command.add("--offset-sigma", "LENGTH", options.offset_sigma,
              "Standard uncertainty of the offset; default: 2 % of the distance of the cords");
  command.add("--tilt", "ANGLE", options.tilt,
              "Standard uncertainty of the level of the car [rad]; default: 2deg");
  add_gravity_option(command, options.gravity);

  const Command watch = command.group("By stop-watch");
  watch.add("--time", "T", options.times,
            "Time of --swings swings [s]; repeat the option for each timing", {one_each()});
  watch.add("--swings", "N", options.swings, "Number of full swings in each timing");
  watch.add("--time-sigma", "T", options.time_sigma,
            "Standard uncertainty of a timing, start and stop [s]; default: 0.15");
  watch.add("--amplitude", "ANGLE", options.amplitude,
            "Amplitude of the first swing timed, from the middle [rad]; default: 10deg");
  watch.add("--amplitude-end", "ANGLE", options.amplitude_end,
            "Amplitude of the last swing timed [rad]; default: half of the first");

  const Command log = command.group("By a gyro's record");
  add_record_options(log, options.record);
  watch.add_rules("--time", {excludes("--can"), excludes("--csv")});
  log.add("--clock-sigma", "X", options.clock_sigma,
          "Standard uncertainty of the rate of the log's clock, relative; default: 0.0001");
  log.add(
      "--gyro-scale-sigma", "X", options.gyro_scale_sigma,
      "Standard uncertainty of the gyro's scale, which gives the amplitude, relative; default: 3%");

  const Command board = command.group("The board that the car stands on");
  board.add("--platform-mass", "MASS", options.platform_mass,
            "Mass of the board that the car stands on [kg], or 310g");
  board.add("--platform-mass-sigma", "MASS", options.platform_mass_sigma,
            "Standard uncertainty of the board's mass; default: 0.2 % of it");
  board.add(
      "--platform-time", "T", options.platform_times,
      "Time of --platform-swings swings of the board alone [s], on the same cords; repeatable",
      {one_each()});
  board.add("--platform-swings", "N", options.platform_swings,
            "Number of swings in each timing of the board alone");
  board.add("--platform-inertia", "J", options.platform_inertia,
            "Inertia of the board [kg m2], instead of swinging it: a board of mass m and edges a "
            "and b has m (a^2 + b^2)/12");
  board.add("--platform-inertia-sigma", "J", options.platform_inertia_sigma,
            "Standard uncertainty of the board's inertia; default: 5 % of it");
}

}  // namespace

void add_inertia(Command identify) {
  auto options = std::make_shared<Options>();
  Command method = identify.add_subcommand("inertia");
  describe_inertia(method, *options);
  add_delivery(method, options, identify_inertia);
  add_strict(method, options->record.damage);
}

}  // namespace odomd::tools
