// odom identify latency: the latency of each source.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/progress.hpp"
#include "tools/cli/text.hpp"
#include "tools/drive_files/camera_csv.hpp"
#include "tools/identify/common/delivery.hpp"
#include "tools/identify/common/option_group.hpp"
#include "tools/identify/latency/actuator_findings.hpp"
#include "tools/identify/latency/latency_estimate.hpp"
#include "tools/identify/methods.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

struct Options {
  std::string config;
  std::vector<std::string> can;
  std::vector<std::string> dbc;
  std::string camera;
  Delivery delivery;
};

bool is_acceleration(Source source) {
  return source == Source::accel_x || source == Source::accel_y;
}

// Signals in the gyro's message were sampled with it.
bool as_old_as_gyro(const daemon::Config& config, Source source) {
  std::string gyro, other;
  for (const can::SignalBinding& binding : config.can.bindings) {
    if (binding.channel == static_cast<std::uint8_t>(Source::yaw_rate)) gyro = binding.message;
    if (binding.channel == static_cast<std::uint8_t>(source)) other = binding.message;
  }
  return gyro == other;
}

constexpr double known_below = 0.01;  // standard uncertainty [s] of a determined value

double configured_latency(const daemon::Config& config, Source source) {
  for (const can::SignalBinding& binding : config.can.bindings)
    if (binding.channel == static_cast<std::uint8_t>(source))
      return 1e-9 * static_cast<double>(binding.latency_ns);
  return 0.0;
}

Finding finding_of(const std::string& name, double measured, double sigma, std::string failure) {
  Finding finding{
      .name = name, .value = measured, .sigma = sigma, .unit = "s", .share = Share::meaningless};
  if (failure.empty() && !(sigma < known_below))
    failure =
        "too little excitation to determine it to 20 ms; drive with more turns "
        "and changes of speed";
  if (!failure.empty()) {
    finding.determined = Determined::no;
    finding.remark = std::move(failure);
  }
  return finding;
}

// Significantly negative: the reference clock is late.
bool is_early(const Finding& finding) {
  constexpr double chance = 3.0;  // standard uncertainties
  return finding.value < -chance * finding.sigma;
}

// Configured latencies are not negative: a slightly negative value becomes 0, a significantly
// negative one is not written.
void into_configuration(Finding& finding, const std::string& key, const std::string& late) {
  if (finding.determined == Determined::no) return;
  const std::string measured = "measured " + fixed(1e3 * finding.value, 1) + " ms";
  if (is_early(finding)) {
    finding.determined = Determined::no;
    finding.remark = measured + ", which is not possible; " + late;
    return;
  }
  finding.key = key;
  if (finding.value >= 0.0) return;
  if (!finding.remark.empty()) finding.remark += "; ";
  finding.remark += measured + ", but a latency cannot be negative";
  finding.value = 0.0;
}

Findings findings_of(const Options& options) {
  check(options.delivery);
  daemon::Config config = daemon::load_config(options.config);
  if (!options.dbc.empty()) config.can.dbc.assign(options.dbc.begin(), options.dbc.end());
  const SignalLog log = read_signals(config, options.can);
  CameraLog camera;
  if (!options.camera.empty()) {
    camera = read_camera_log(options.camera);
    if (camera.poses.empty()) camera.warnings.push_back(no_camera_pose(options.camera));
  }
  ProgressLine progress("odom identify latency");
  const LatencyEstimate estimate = estimate_latencies(
      config, log, camera.poses, [&progress](const std::string& now) { progress.show(now); });
  progress.end();

  Findings findings{
      .method = "latency", .origin = "", .values = {}, .warnings = log.warnings, .details = {}};
  findings.origin =
      fixed(1e-9 * static_cast<double>(log.last_ns - log.first_ns), 0) + " s of drive";
  append(findings.warnings, camera.warnings);
  append(findings.warnings, estimate.warnings);

  // With a camera its stamps are the clock; without one the gyro's configured latency is used.
  double gyro_offset = 0.0, gyro_sigma = 0.0;
  bool clock_of_camera = false;
  for (const SourceOffset& found : estimate.offsets) {
    if (found.source != Source::camera) continue;
    Finding gyro = finding_of("latency of yaw_rate",
                              configured_latency(config, Source::yaw_rate) - found.offset,
                              found.sigma, found.failure);
    gyro.remark = gyro.determined == Determined::yes
                      ? "against the camera's stamps"
                      : gyro.remark + "; is the camera's file of this drive?";
    findings.details["measured"]["yaw_rate"] = gyro.value;
    clock_of_camera = gyro.determined == Determined::yes && !is_early(gyro);
    if (clock_of_camera) {
      gyro_offset = -found.offset;
      gyro_sigma = found.sigma;
    }
    into_configuration(gyro, "can.signals.yaw_rate.latency",
                       "t_capture is when the picture was taken: are the poses stamped later?");
    findings.values.push_back(std::move(gyro));
  }
  if (options.camera.empty() || !clock_of_camera)
    findings.warnings.push_back(
        diagnostics::found(diagnostics::kind("latencies_relative"), {},
                           "the gyro's configured latency, " +
                               fixed(1e3 * configured_latency(config, Source::yaw_rate), 1) +
                               " ms, is assumed to be correct: all others are relative to it"));

  const std::string question =
      clock_of_camera ? "are the camera's poses stamped later than the pictures were taken?"
                      : "is yaw_rate later than its configured latency?";
  for (const SourceOffset& found : estimate.offsets) {
    if (found.source == Source::camera) continue;
    const std::string role{estimator::source_names[static_cast<std::size_t>(found.source)]};
    Finding finding = finding_of(
        "latency of " + role, configured_latency(config, found.source) + found.offset + gyro_offset,
        std::hypot(found.sigma, gyro_sigma), found.failure);
    findings.details["measured"][role] = finding.value;
    findings.details["explained"][role] = found.explained;
    // Tyres and slopes also affect an acceleration, and shift it by tens of milliseconds.
    if (is_acceleration(found.source)) {
      const std::string measured = "measured " + fixed(1e3 * finding.value, 0) +
                                   " ms, which drag and slip of the tyres shift by tens of ms";
      const bool with_gyro = clock_of_camera && as_old_as_gyro(config, found.source);
      finding = with_gyro
                    ? finding_of("latency of " + role,
                                 configured_latency(config, Source::yaw_rate) + gyro_offset,
                                 gyro_sigma, "")
                    : finding_of("latency of " + role, finding.value, finding.sigma, measured);
      if (with_gyro) {
        finding.remark = "as the gyro, from the same message";
        into_configuration(finding, "can.signals." + role + ".latency", question);
      }
      findings.values.push_back(std::move(finding));
      continue;
    }
    if (finding.determined == Determined::yes) finding.remark = "against " + found.against;
    into_configuration(finding, "can.signals." + role + ".latency", question);
    findings.values.push_back(std::move(finding));
  }
  if (estimate.steering) {
    const SteeringResponse& s = *estimate.steering;
    const double late = configured_latency(config, Source::steering) + gyro_offset;
    const auto sigma = [&](const Measured& m) { return std::hypot(m.sigma, gyro_sigma); };
    Finding all = finding_of("lag of the wheels behind steering, in all", s.in_all.value - late,
                             sigma(s.in_all), s.failure);
    if (all.determined == Determined::yes) all.remark = "delay and lag together";
    findings.values.push_back(all);
    ActuatorFindings actuator =
        actuator_findings(s, {gyro_offset, gyro_sigma}, config.vehicle.steering);
    for (Finding& finding : actuator.values) findings.values.push_back(std::move(finding));
    append(findings.warnings, actuator.warnings);
    findings.details["measured"]["steering_lag"] = all.value;
    findings.details["measured"]["steering_dead_time"] = s.dead_time.value - late;
    findings.details["measured"]["steering_time_constant"] = s.time_constant.value;
    findings.details["explained"]["steering"] = s.explained;
    // A sensor of the wheels' angle may be late itself: then they move before its signal.
    if (all.determined == Determined::yes && all.value < -2.0 * all.sigma) {
      Finding late_sensor = finding_of("latency of steering", -all.value, all.sigma, "");
      late_sensor.remark = "the car turns before it";
      late_sensor.key = "can.signals.steering.latency";
      findings.values.push_back(std::move(late_sensor));
    }
  }
  return findings;
}

}  // namespace

void add_latency(Command identify) {
  auto options = std::make_shared<Options>();
  Command latency = identify.add_subcommand(
      "latency",
      "Measure how late each source is against the gyro or the camera, and the steering's lag");
  const OptionGroup all{latency, ""};
  all.add("--config", "TOML", options->config, "Configuration of the car").required();
  all.add("--can", "LOG", options->can, "Log of the drive, candump -L; repeatable").required();
  all.add("--dbc", "FILE", options->dbc, "Databases in place of the configuration's; repeatable");
  all.add("--camera", "CSV", options->camera, "Camera poses of the same drive");
  add_delivery(latency, options->delivery);
  latency.footer(R"(Drive for ten minutes with a camera: quick curves to both sides, with a stop
every few metres, no two stretches alike, and slowly: below 3 m/s2 of lateral acceleration,
a 1:10 car at 0.5 to 1 m/s. What is smooth has no time; at a speed that never changes the
steering's lag and the tyres' are one; the faster, the later wheels turn than the ground by
their own inertia. Mass, axles, inertia and stiffnesses must be in the configuration.

Each source is compared with another and shifted in time until they agree:
  camera       its yaw with the integral of the gyro
  wheels       the difference of left and right with the gyro; one alone: its distance with the
               camera's
  accel_x      as the gyro if it is in the same message; else only shown, compared with the
               wheels' acceleration
  accel_y      likewise, compared with speed times yaw rate
  steering     the yaw rate of a car with these tyres, with the gyro: delay and lag
               between command and wheels, for [steering], and a rate limit if it
               shows; none if the angle is measured
With a camera its capture stamps are the clock, and the gyro's own latency is found too.
Without one the gyro's configured latency is used. The offsets found add to those in the
configuration: run it again after --write, and all offsets are small.
Examples:
  odom identify latency --config car.toml --can drive.log --camera camera.csv
  odom identify latency --config car.toml --can drive.log --write car.toml)");
  latency.callback([options] { deliver(findings_of(*options), options->delivery); });
}

}  // namespace odomd::tools
