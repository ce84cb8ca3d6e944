// odom identify inertia: the yaw inertia, by the period in which the car turns on two cords.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/identify/common/delivery.hpp"
#include "tools/identify/common/quantity.hpp"
#include "tools/identify/common/record.hpp"
#include "tools/identify/inertia/bifilar.hpp"
#include "tools/identify/inertia/inertia_options.hpp"
#include "tools/identify/inertia/propagation.hpp"
#include "tools/identify/inertia/swing_fit.hpp"
#include "tools/identify/inertia/swing_timing.hpp"
#include "tools/identify/methods.hpp"
#include "tools/identify/weighing/scale_options.hpp"

namespace odomd::tools {
namespace {

struct Period {
  Measured small;  ///< of small swings [s]
  std::string origin;
};

/// From the record: adds the uncertainty of the clock's rate, and of the amplitude from the gyro's
/// scale, to that of the fit.
Period period_of_record(const InertiaOptions& options, const Bifilar& pendulum,
                        Findings& findings) {
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

Period period_of_car(const InertiaOptions& options, const Bifilar& pendulum, Findings& findings) {
  const bool recorded = is_given(options.record);
  if (recorded == !options.times.empty())
    throw std::invalid_argument(
        recorded ? "--time and a record: give one of them"
                 : "give --time and --swings, --csv, or --config and --can; odom identify inertia "
                   "--help explains each");
  return recorded ? period_of_record(options, pendulum, findings)
                  : period_of_watch(watch_of_car(options), pendulum, findings);
}

// The inputs in the order of inertia_on_cords().
std::vector<Input> inputs_of(const InertiaOptions& options, const Bifilar& pendulum,
                             const Measured& mass, const Measured& period) {
  const Measured off = offset_square(options, pendulum);
  const double tape =
      parse_not_negative(options.spacing_sigma, Dimension::length, "--spacing-sigma");
  const double tilt = parse_not_negative(options.tilt, Dimension::angle, "--tilt");
  return {
      {"mass", mass},
      {"gravity", gravity_of(options.gravity)},
      {"distance of the cords above", {pendulum.spacing_above, tape}},
      {"distance of the cords below", {pendulum.spacing_below, tape}},
      {"length of the cords",
       {pendulum.cord, parse_not_negative(options.cord_sigma, Dimension::length, "--cord-sigma")}},
      {"period", period},
      {"offset of the centre of gravity", off},
      // Tilted by τ it swings about another axis: J cos²τ + J_x sin²τ, where J_x of a car is about
      // a third.
      {"tilt of the car", {0.0, 0.7 * tilt * tilt}}};
}

std::vector<Input> platform_inputs(const InertiaOptions& options, const Bifilar& pendulum,
                                   Platform platform) {
  if (platform == Platform::none) return {};
  const Input mass{"mass of the platform", mass_of_platform(options)};
  if (platform == Platform::given)
    return {mass, {"inertia of the platform", inertia_of_platform(options)}};
  return {mass,
          {"period of the platform", small_period_of(watch_of_platform(options), pendulum).period}};
}

// J = (m + m_p) g p T² / (4 π² h) - J_p
Propagated inertia_on_cords(const InertiaOptions& options, const Bifilar& pendulum,
                            const Measured& mass, const Measured& period) {
  std::vector<Input> inputs = inputs_of(options, pendulum, mass, period);
  const std::size_t own = inputs.size();
  const Platform platform = platform_of(options);
  for (Input& input : platform_inputs(options, pendulum, platform))
    inputs.push_back(std::move(input));

  Propagated inertia = propagate(inputs, [&](const std::vector<double>& x) {
    Bifilar hung{.spacing_above = x[2],
                 .spacing_below = x[3],
                 .cord = x[4],
                 .offset = std::sqrt(std::fmax(x[6], 0.0))};
    const double carried = platform == Platform::none ? 0.0 : x[own];
    const double whole = inertia_of(hung, x[0] + carried, x[1], x[5]) * (1.0 + x[7]);
    if (platform == Platform::none) return whole;
    if (platform == Platform::given) return whole - x[own + 1];
    hung.offset = 0.0;  // of the platform alone
    return whole - inertia_of(hung, carried, x[1], x[own + 1]);
  });
  if (!(inertia.result.value > 0.0))
    throw std::invalid_argument("the platform has more inertia than car and platform together");
  return inertia;
}

/// J / (m l_v l_h) of cars is about 1; it is a quarter if passages were counted instead of swings.
void compare_with_axles(const std::string& file, double mass, double inertia, Findings& findings) {
  const auto front = number_in(file, "vehicle.front_axle");
  const auto rear = number_in(file, "vehicle.rear_axle");
  if (!front || !rear || !(*front * *rear > 0.0)) return;
  const double ratio = inertia / (mass * *front * *rear);
  constexpr double least = 0.4, most = 2.0;
  if (ratio > least && ratio < most) return;
  findings.warnings.push_back(
      found(diagnostics::kind("measured_inertia_unlike"), file,
            fmt::format("the yaw inertia is {:.2g} times m l_v l_h with its axles, and cars have "
                        "{} to {}",
                        ratio, least, most)));
}

void identify_inertia(const InertiaOptions& options) {
  check(options.delivery);
  Findings findings{.method = "inertia"};
  const Bifilar pendulum = pendulum_of(options);
  const Period period = period_of_car(options, pendulum, findings);
  const Measured mass = mass_of_car(options);
  check_size(pendulum, period.small.value);
  check_mass(pendulum, period.small.value, mass.value);
  const Propagated inertia = inertia_on_cords(options, pendulum, mass, period.small);

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
  if (!diagnostics::kind("inertia_uncertain")
           .limits.hold(2.0 * inertia.result.sigma / inertia.result.value))
    findings.warnings.push_back(
        found(diagnostics::kind("inertia_uncertain"), {},
              "2 sigma is more than 2 %: " + largest_contributions(inertia)));
  const std::string& config =
      options.delivery.write.empty() ? options.record.config : options.delivery.write;
  if (!config.empty()) compare_with_axles(config, mass.value, inertia.result.value, findings);
  deliver(findings, options.delivery);
}

}  // namespace

void add_inertia(Command identify) {
  auto options = std::make_shared<InertiaOptions>();
  Command method = identify.add_subcommand("inertia");
  describe_inertia(method, *options);
  method.callback([options] { identify_inertia(*options); });
}

}  // namespace odomd::tools
