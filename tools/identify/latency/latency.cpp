// odom identify latency: the latency of each source.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/latency/latency_estimate.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

using estimator::Source;

struct Options {
  std::string config;
  std::vector<std::string> can;
  std::vector<std::string> dbc;
  can::Damage damage = can::Damage::left_out;
  std::string camera;
  Delivery delivery;
};

constexpr double known_below = 0.01;  // standard uncertainty [s] of a determined value

/// Adds a time, which is determined if it is known to 20 ms.
Finding& add_time(Findings& findings, const std::string& name, const Measured& measured,
                  const std::string& failure, const std::string& remark) {
  Finding& finding = findings.add(name, "", measured, "s", remark);
  finding.share = Share::meaningless;
  if (!failure.empty())
    finding.reject(failure);
  else if (!(measured.sigma < known_below))
    finding.reject(
        "too little excitation to determine it to 20 ms; drive with more turns and changes of "
        "speed");
  return finding;
}

// Configured latencies are not negative: slightly negative values become 0. Significantly negative
// ones are not written, as the reference clock must be late.
void assign_key(Finding& finding, Source source, const std::string& question) {
  constexpr double chance = 3.0;  // standard uncertainties
  if (finding.determined == Determined::no) return;
  if (finding.value < -chance * finding.sigma) {
    const std::string measured = fixed(1e3 * finding.value, 1);
    return finding.reject("measured " + measured + " ms, which is not possible; " + question);
  }
  finding.key = key_of(source, ".latency");
  raise_to_zero(finding);
}

// The reference for all sources but the camera: the stamps of the camera if there is one, otherwise
// the gyro with its configured latency.
struct Clock {
  Measured gyro{};  // excess of the gyro's latency over the configured one
  bool of_camera = false;

  [[nodiscard]] std::string question() const {
    return of_camera ? "are the camera's poses stamped later than the pictures were taken?"
                     : "is yaw_rate later than its configured latency?";
  }
};

Clock add_gyro(const daemon::Config& config, const SourceOffset& camera, Findings& findings) {
  const Measured latency{configured_latency(config, Source::yaw_rate) - camera.offset,
                         camera.sigma};
  Finding& gyro = add_time(findings, "latency of yaw_rate", latency, camera.failure,
                           "against the camera's stamps");
  if (gyro.determined == Determined::no) gyro.remark += "; is the camera's file from this drive?";
  findings.details["measured"]["yaw_rate"] = gyro.value;
  assign_key(gyro, Source::yaw_rate,
             "t_capture is when the picture was taken: are the poses stamped later?");
  if (gyro.determined == Determined::no) return {};
  return {.gyro = {-camera.offset, camera.sigma}, .of_camera = true};
}

void add_source(const daemon::Config& config, const Clock& clock, const SourceOffset& found,
                Findings& findings) {
  const std::string role = name_of(found.source);
  const Measured latency{configured_latency(config, found.source) + found.offset + clock.gyro.value,
                         std::hypot(found.sigma, clock.gyro.sigma)};
  findings.details["measured"][role] = latency.value;
  findings.details["explained"][role] = found.explained;
  assign_key(
      add_time(findings, "latency of " + role, latency, found.failure, "against " + found.against),
      found.source, clock.question());
}

// Drag and slip of the tyres shift an acceleration by tens of milliseconds, so its latency is only
// known if it comes in the gyro's message, sampled with it.
void add_accel(const daemon::Config& config, const Clock& clock, Source source,
               Findings& findings) {
  const can::SignalBinding *gyro = binding_of(config, Source::yaw_rate),
                           *own = binding_of(config, source);
  const bool known = clock.of_camera && gyro->message == own->message;
  Measured latency;
  if (known)
    latency = {configured_latency(config, Source::yaw_rate) + clock.gyro.value, clock.gyro.sigma};
  assign_key(add_time(findings, "latency of " + name_of(source), latency,
                      known ? "" : "only known in the gyro's message, with a camera",
                      "as the gyro, from the same message"),
             source, clock.question());
}

void add_steering(const daemon::Config& config, const Clock& clock, const SteeringResponse& s,
                  Findings& findings) {
  const double late = configured_latency(config, Source::steering) + clock.gyro.value;
  const Finding all =
      add_time(findings, "lag of the wheels behind steering, in all",
               {s.in_all.value - late, std::hypot(s.in_all.sigma, clock.gyro.sigma)}, s.failure,
               "delay and lag together");
  add_actuator(s, clock.gyro, config.vehicle.steering, findings);
  findings.details["measured"]["steering_lag"] = all.value;
  findings.details["measured"]["steering_dead_time"] = s.dead_time.value - late;
  findings.details["measured"]["steering_time_constant"] = s.time_constant.value;
  findings.details["explained"]["steering"] = s.explained;
  // A wheel-angle sensor may be late: then the wheels move before its signal does.
  if (all.determined == Determined::no || all.value >= -2.0 * all.sigma) return;
  add_time(findings, "latency of steering", {-all.value, all.sigma}, "", "the car turns before it")
      .key = key_of(Source::steering, ".latency");
}

Findings findings_of(const Options& options) {
  daemon::Config config = daemon::load_config(options.config);
  if (!options.dbc.empty()) config.can.dbc.assign(options.dbc.begin(), options.dbc.end());
  const SignalLog log = read_signals(config, options.can, options.damage);
  CameraLog camera;
  if (!options.camera.empty()) {
    camera = read_camera_log(options.camera);
    if (camera.poses.empty()) camera.warnings.push_back(no_camera_pose(options.camera));
  }
  ProgressLine progress("odom identify latency");
  const LatencyEstimate estimate = estimate_latencies(
      config, log, camera.poses, [&progress](const std::string& now) { progress.show(now); });
  progress.end();

  Findings findings{.method = "latency", .warnings = log.warnings};
  findings.origin =
      fixed(1e-9 * static_cast<double>(log.last_ns - log.first_ns), 0) + " s of drive";
  append(findings.warnings, camera.warnings);

  Clock clock;
  for (const SourceOffset& found : estimate.offsets)
    if (found.source == Source::camera) clock = add_gyro(config, found, findings);
  if (options.camera.empty() || !clock.of_camera)
    add_warning(findings.warnings, tools::kind("latencies_relative"), {},
                "the gyro's configured latency, {} ms, is assumed to be correct: all others are "
                "relative to it",
                fixed(1e3 * configured_latency(config, Source::yaw_rate), 1));
  for (const SourceOffset& found : estimate.offsets)
    if (found.source != Source::camera) add_source(config, clock, found, findings);
  for (const Source source : {Source::accel_x, Source::accel_y})
    if (log.has(source)) add_accel(config, clock, source, findings);
  if (estimate.steering) add_steering(config, clock, *estimate.steering, findings);
  return findings;
}

}  // namespace

void add_latency(Command identify) {
  auto options = std::make_shared<Options>();
  Command latency = identify.add_subcommand(
      "latency",
      "Measure how late each source is against the gyro or the camera, and the steering's lag");
  latency.add("--config", "TOML", options->config, "Configuration of the car (TOML)", {required()});
  latency.add("--can", "LOG", options->can, "Log of candump -L; repeatable", {required()});
  latency.add("--dbc", "FILE", options->dbc, "Database (DBC); repeatable; instead of [can] dbc");
  latency.add("--camera", "CSV", options->camera, "Camera log of the same drive");
  latency.footer(R"(Drive for ten minutes with a camera: quick curves to both sides, with a stop
every few metres, and no two sections alike. Smooth signals have no timing information, so
steer abruptly. Vary the speed: otherwise the lags of steering and tyres cannot be
separated. Drive slowly, below 3 m/s2 of lateral acceleration (a 1:10 car at 0.5 to 1 m/s):
the faster the car, the more the inertia of the wheels makes them lag behind the ground.
Mass, axles, inertia and stiffnesses must be in the configuration.

Each source is compared with another and shifted in time until they agree:
  camera       its yaw with the integral of the gyro
  wheels       the difference of left and right with the gyro; a single one: its distance with
               that of the camera
  accel_x, _y  take the latency of a gyro in the same message, with a camera only; drag and
               tyres shift what they show
  steering     the yaw rate of a car with these tyres with the gyro: delay and lag between
               command and wheels, for [steering]; none if the angle is measured
The capture stamps of the camera are the time reference, so the latency of the gyro is found,
too. Without a camera, the gyro with its configured latency is the reference. The result
adds to the latencies in the configuration: run the command again after --write; all offsets
should then be near zero.

Examples:
  odom identify latency --config car.toml --can drive.log --camera camera.csv
  odom identify latency --config car.toml --can drive.log --write car.toml)");
  add_delivery(latency, options, findings_of);
  add_strict(latency, options->damage);
}

}  // namespace odomd::tools
