// odom identify inertia: the yaw inertia, from the period of the car's swings on two cords.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <span>

#include "tools/cli/text.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/inputs.hpp"
#include "tools/identify/inertia/bifilar.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

struct Options {
  RecordOptions record;
  std::vector<std::string> times;
  int swings = 0;
  std::string mass, mass_sigma;
  std::string spacing, spacing_below, spacing_sigma = "0.5mm";
  std::string cord, cord_sigma = "2mm";
  std::string offset_sigma;
  std::string amplitude = "10deg", amplitude_end;
  std::string time_sigma = "0.15";
  std::string gravity;
  Delivery delivery;
};

Bifilar pendulum_of(const Options& options) {
  constexpr Plausible between_cords{0.01, 10.0}, along_cords{0.05, 50.0};  // m
  const auto length = [](const std::string& text, const std::string& option, Plausible range) {
    return parse_plausible(text, Dimension::length, option, range);
  };
  const std::string& below =
      options.spacing_below.empty() ? options.spacing : options.spacing_below;
  const Bifilar pendulum{.spacing_above = length(options.spacing, "--spacing", between_cords),
                         .spacing_below = length(below, "--spacing-below", between_cords),
                         .cord = length(options.cord, "--cord", along_cords)};
  check(pendulum);
  return pendulum;
}

/// The mass as given, or from the configuration; the default uncertainty suits a kitchen scale.
Measured mass_of_car(const Options& options, const std::string& config) {
  constexpr double kitchen_scale = 0.002;
  if (!options.mass.empty()) {
    const double mass = parse_positive(options.mass, Dimension::mass, "--mass");
    return {mass,
            parse_or(kitchen_scale * mass, options.mass_sigma, Dimension::mass, "--mass-sigma")};
  }
  auto mass = config.empty() ? std::nullopt : measured_in(config, "vehicle.mass");
  if (!mass) refuse("the mass is missing; give --mass, or a --config with [vehicle] mass");
  if (mass->sigma == 0.0) mass->sigma = kitchen_scale * mass->value;
  return *mass;
}

/// The period of small swings from the record. Its uncertainty combines those of the fit, of the
/// clock's rate, and of the amplitude (the gyro's scale).
Measured period_of_record(const Options& options, const Bifilar& pendulum, Findings& findings) {
  const SignalLog log = read_record(options.record, {estimator::Source::yaw_rate});
  append(findings.warnings, log.warnings);
  const SwingFit fit =
      fit_swing(log.need(estimator::Source::yaw_rate), pendulum, options.record.name());
  append(findings.warnings, fit.warnings);
  const double rms_amplitude = std::hypot(fit.amplitude_begin, fit.amplitude_end) / std::sqrt(2.0);
  const double correction =
      lengthening(pendulum, inertia_per_mass(pendulum, fit.period.value), rms_amplitude) - 1.0;
  constexpr double scale = 0.03, clock = 1e-4;  // relative errors of uncalibrated gyro, quartz
  findings.details["swing"] = {{"swings", fit.swings},
                               {"amplitude_begin", fit.amplitude_begin},
                               {"amplitude_end", fit.amplitude_end},
                               {"gyro_bias", fit.gyro_bias},
                               {"lengthening", correction}};
  const double relative = std::hypot(clock, 2.0 * scale * correction);
  findings.origin = fmt::format("bifilar pendulum, gyro, {:.0f} swings", fit.swings);
  return {fit.period.value, std::hypot(fit.period.sigma, relative * fit.period.value)};
}

Measured period_of_watch(const Options& options, const Bifilar& pendulum, Findings& findings) {
  StopWatch watch{.swings = options.swings};
  for (const std::string& text : options.times)
    watch.times.push_back(parse_positive(text, Dimension::time, "--time"));
  if (watch.swings < 1) refuse("--swings is missing: how many full swings did each --time take?");
  watch.sigma = parse_not_negative(options.time_sigma, Dimension::time, "--time-sigma");
  watch.amplitude_begin = parse_not_negative(options.amplitude, Dimension::angle, "--amplitude");
  watch.amplitude_end = parse_or(0.5 * watch.amplitude_begin, options.amplitude_end,
                                 Dimension::angle, "--amplitude-end");
  const TimedSwing swing = small_period_of(watch, pendulum);
  append(findings.warnings, swing.warnings);
  findings.details["swing"] = {{"swings", watch.swings},
                               {"timings", watch.times.size()},
                               {"lengthening", swing.lengthening}};
  findings.origin = fmt::format("bifilar pendulum, stop-watch, {} of {} swings",
                                counted(watch.times.size(), "timing"), watch.swings);
  return swing.period;
}

Measured period_of_car(const Options& options, const Bifilar& pendulum, Findings& findings) {
  if (options.record.is_given()) return period_of_record(options, pendulum, findings);
  if (!options.times.empty()) return period_of_watch(options, pendulum, findings);
  refuse(
      "give --time and --swings, --csv, or --config and --can; odom identify inertia --help "
      "explains each");
}

/// The local gravity, or the mean of the range from the equator (9.780) to the poles (9.832).
Measured gravity_of(const std::string& text) {
  if (text.empty()) return {9.806, 0.015};
  const double value = parse_positive(text, Dimension::pure, "--gravity");
  if (value < 9.7 || value > 9.9)
    refuse("--gravity: {} does not occur on Earth; give 9.76 to 9.84", text);
  return {value, 0.001};
}

/// A name, and the variable from which the result is computed.
using Input = std::pair<const char*, Measured*>;

struct Propagated {
  Measured result;
  /// For each input: the result's uncertainty from this input alone, and the input's name.
  std::vector<std::pair<double, const char*>> contributions;
};

/// `result` computes with the variables that the inputs point to; these are changed one by one and
/// restored. Inputs are independent: correlated quantities must be computed inside `result`.
Propagated propagate(std::span<const Input> inputs, const std::function<double()>& result) {
  Propagated propagated;
  propagated.result.value = result();
  double variance = 0.0;
  for (const auto& [name, input] : inputs) {
    const Measured kept = *input;
    input->value = kept.value + kept.sigma;
    const double above = result();
    input->value = kept.value - kept.sigma;
    const double part = 0.5 * std::fabs(above - result());
    *input = kept;
    propagated.contributions.emplace_back(part, name);
    variance += part * part;
  }
  propagated.result.sigma = std::sqrt(variance);
  return propagated;
}

/// "mostly from the distance of the cords (71 %) and the swing's period (20 %)": shares of the
/// variance.
std::string largest_contributions(const Propagated& propagated) {
  const double variance = propagated.result.sigma * propagated.result.sigma;
  if (!(variance > 0.0)) return "";
  auto parts = propagated.contributions;
  std::ranges::stable_sort(parts, std::greater<>{}, [](const auto& part) { return part.first; });
  const auto share = [variance](double sigma) { return 100.0 * sigma * sigma / variance; };
  std::string text =
      fmt::format("mostly from the {} ({:.0f} %)", parts[0].second, share(parts[0].first));
  if (share(parts[1].first) >= 10.0)
    text += fmt::format(" and the {} ({:.0f} %)", parts[1].second, share(parts[1].first));
  return text;
}

// J = m g p T² / (4 π² h)
Propagated inertia_on_cords(const Options& options, const Bifilar& pendulum, Measured mass,
                            Measured period) {
  const double tape =
      parse_not_negative(options.spacing_sigma, Dimension::length, "--spacing-sigma");
  constexpr double level = 2.0 * std::numbers::pi / 180.0;
  // Only the square of the offset matters; its mean is sigma².
  const double variance = std::pow(parse_or(0.02 * pendulum.spacing_below, options.offset_sigma,
                                            Dimension::length, "--offset-sigma"),
                                   2);
  Measured gravity = gravity_of(options.gravity);
  Measured above{pendulum.spacing_above, tape}, below{pendulum.spacing_below, tape};
  Measured cord{pendulum.cord,
                parse_not_negative(options.cord_sigma, Dimension::length, "--cord-sigma")};
  Measured offset2{variance, std::numbers::sqrt2 * variance};
  // A car tilted by τ swings about another axis: J cos²τ + J_x sin²τ, where a car's J_x is about a
  // third of J.
  Measured tilt{0.0, 0.7 * level * level};
  const std::vector<Input> inputs{{"mass", &mass},
                                  {"gravity", &gravity},
                                  {"distance of the cords above", &above},
                                  {"distance of the cords below", &below},
                                  {"length of the cords", &cord},
                                  {"period", &period},
                                  {"offset of the centre of gravity", &offset2},
                                  {"tilt of the car", &tilt}};
  return propagate(inputs, [&] {
    const Bifilar hung{.spacing_above = above.value,
                       .spacing_below = below.value,
                       .cord = cord.value,
                       .offset = std::sqrt(std::fmax(offset2.value, 0.0))};
    return mass.value * inertia_per_mass(hung, period.value, gravity.value) * (1.0 + tilt.value);
  });
}

/// Warns if J / (m l_v l_h) is far from 1, its usual value for cars. If passages were counted
/// instead of swings, the inertia is a quarter of the true one.
void compare_with_axles(const std::string& config, double mass, double inertia,
                        Findings& findings) {
  const auto front = value_in(config, "vehicle.front_axle");
  const auto rear = value_in(config, "vehicle.rear_axle");
  if (!front || !rear || !(front->value * rear->value > 0.0)) return;
  const double ratio = inertia / (mass * front->value * rear->value);
  constexpr double least = 0.4, most = 2.0;
  if (ratio > least && ratio < most) return;
  add_warning(findings.warnings, tools::kind("measured_inertia_unlike"), config,
              "the yaw inertia is {:.2g} times m l_v l_h with its axles, and cars have "
              "{} to {}",
              ratio, least, most);
}

Findings identify_inertia(const Options& options) {
  Findings findings{.method = "inertia"};
  const Bifilar pendulum = pendulum_of(options);
  const Measured period = period_of_car(options, pendulum, findings);
  const std::string& config =
      options.record.config.empty() ? options.delivery.write : options.record.config;
  const Measured mass = mass_of_car(options, config);
  check_size(pendulum, period.value, mass.value);
  const Propagated inertia = inertia_on_cords(options, pendulum, mass, period);

  findings.add("yaw inertia", "vehicle.yaw_inertia", inertia.result, "kg m2",
               largest_contributions(inertia));
  findings.add("period of small swings", "", period, "s");
  for (const auto& [sigma, input] : inertia.contributions)
    findings.details["contributions"][input] = sigma;
  if (!tools::kind("inertia_uncertain")
           .limits.hold(2.0 * inertia.result.sigma / inertia.result.value))
    add_warning(findings.warnings, tools::kind("inertia_uncertain"), {},
                "2 sigma is more than 2 %: {}", largest_contributions(inertia));
  if (!config.empty()) compare_with_axles(config, mass.value, inertia.result.value, findings);
  return findings;
}

}  // namespace

void add_inertia(Command identify) {
  const auto options = std::make_shared<Options>();
  const Command method = identify.add_subcommand(
      "inertia", "Measure the yaw inertia by swinging the car on two cords");
  method.footer(
      R"(Hang the car level on two thin vertical cords of equal length, one on each side of its
centre of gravity and at equal distance from it. Turn the car by 10 to 20 degrees about the
vertical, let it come to rest there, and release it without a push. Record its gyro for a
minute, or time 20 full swings three times with a stop-watch: from one passage through the
middle to the 20th passage after it in the same direction.

Precision: the inertia is J = m g D^2 T^2 / (16 pi^2 L), with the distance D between the
cords, their length L and the period T. An error of 1 % in D causes 2 % in J, an error of
1 % in m or L causes 1 %. Measure D to 0.5 mm at top and bottom, and L under load between
the attachment points. Make L at least 3 D: with long cords the car swings slowly, and both
are measured more precisely. The amplitude and its decay are corrected for; with a
stop-watch, state --amplitude. An offset e of the centre of gravity along the line of the
cords reduces J by the fraction 4 e^2/D^2: hang the car so that both cords are equally
tight. A tilt of 5 degrees reduces J by 0.5 %: level the car to 2 degrees.

Examples:
  odom identify inertia --measured swing/measured.json --config car.toml \
      --can swing/drive.log --write car.toml
  odom identify inertia --mass 2985g --spacing 0.2 --cord 1.2 --swings 20 --time 42.81 \
      --time 42.95 --time 42.77 --amplitude 15deg --amplitude-end 8deg
  odom identify inertia --mass 2.985 --spacing 0.2 --cord 1.2 --csv phone.csv)");

  add_measured_option(method);
  method.add("--mass", "MASS", options->mass,
             "Mass of the car as it hangs [kg], or 2985g; default: that of --config or --write, "
             "with the uncertainty in its note");
  method.add("--mass-sigma", "MASS", options->mass_sigma,
             "Standard uncertainty of the mass; default: 0.2 % of it");
  method.add("--spacing", "LENGTH", options->spacing, "Distance between the cords [m], or 200mm",
             {required()});
  method.add("--spacing-below", "LENGTH", options->spacing_below,
             "Distance between the cords at the car, if different; default: the same");
  method.add("--spacing-sigma", "LENGTH", options->spacing_sigma,
             "Standard uncertainty of each distance between the cords; default: 0.5mm");
  method.add("--cord", "LENGTH", options->cord,
             "Length of the cords between their attachment points, under load [m]", {required()});
  method.add("--cord-sigma", "LENGTH", options->cord_sigma,
             "Standard uncertainty of the cords' length; default: 2mm");
  method.add("--offset-sigma", "LENGTH", options->offset_sigma,
             "Standard uncertainty of the centre of gravity's offset from the middle, along the "
             "line of the cords; default: 2 % of their distance");
  method.add("--gravity", "G", options->gravity,
             "Local gravity [m/s2], known to 0.001; default: 9.806 +- 0.015, anywhere on Earth");

  const Command watch = method.group("With a stop-watch");
  watch.add("--time", "T", options->times,
            "Time for --swings swings [s]; repeat the option for each timing", {one_each()});
  watch.add("--swings", "N", options->swings, "Number of full swings in each timing");
  watch.add("--time-sigma", "T", options->time_sigma,
            "Standard uncertainty of a timing, including start and stop [s]; default: 0.15");
  watch.add("--amplitude", "ANGLE", options->amplitude,
            "Amplitude of the first timed swing, from the middle [rad]; default: 10deg");
  watch.add("--amplitude-end", "ANGLE", options->amplitude_end,
            "Amplitude of the last timed swing [rad]; default: half of the first");

  const Command log = method.group("With a record of the gyro");
  add_record_options(log, options->record);
  watch.add_rules("--time", {excludes("--can"), excludes("--csv")});
  add_delivery(method, options, identify_inertia);
  add_strict(method, options->record.damage);
}

}  // namespace odomd::tools
