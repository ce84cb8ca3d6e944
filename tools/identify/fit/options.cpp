// The command lines of odom identify fit and track; programs of their own do the work.
#include "tools/identify/fit/options.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>

#include "tools/cli/command_line.hpp"
#include "tools/cli/text.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/fit/parameters.hpp"
#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

void describe_fit(Command command, FitOptions& options) {
  command.description("Fit all parameters at once, on a drive with camera poses or a reference");
  command.add("--config", "TOML", options.config,
              "Configuration of the car (TOML) to start from, as measured by hand; default: the "
              "drive's car.toml");
  command.add("--drive,DIR", "DIR", options.drives,
              "Folder with drive.log (or can.log) and camera.csv (or truth.csv); repeatable",
              {required()});
  command.add_flag("--use-reference", options.use_reference,
                   "Use truth.csv of each --drive instead of camera.csv");
  command.add("--dbc", "FILE", options.dbc, "Database (DBC); repeatable; instead of [can] dbc");
  command.add("--from", "S", options.from,
              "Start time [s] after the log's first frame; default: 0");
  command.add("--to", "S", options.to,
              "End time [s] after the log's first frame; default: its end");
  command.add("--fix", "NAME", options.fixed, "Leave this parameter as configured; repeatable");
  command.add("--free", "NAME", options.freed,
              "Also fit this parameter; by default load_lag, drive_spin and parameters that no "
              "mapped signal shows stay as configured; repeatable");
  command.add("--prior", "NAME=SIGMA", options.priors,
              "Standard uncertainty of a parameter before the fit, in its unit, or relative for "
              "those marked * (0.02: 2 %); default for the mass: 0.01; repeatable");
  command.add("--threads", "N", options.threads, "Number of threads, 1 to 64; default: 1",
              {within(1, 64, Bounds::in_text)});
  command.add_flag("--untried", options.untried,
                   "Write every determined value, without the replays that otherwise decide which "
                   "ones are written");
  command.add_flag("--quiet", options.quiet, "Do not show progress");
  add_delivery(command, options.delivery);
  add_strict(command, options.damage);
  std::string names;
  for (const fitting::ParameterInfo& info : fitting::parameter_table()) {
    const bool relative = info.kind == fitting::ParameterKind::factor;
    const std::string unit = info.unit.empty() ? "" : fmt::format(" [{}]", info.unit);
    names += fmt::format("\n  {:<23} {} {}{}", info.name, relative ? '*' : ' ', info.meaning, unit);
  }
  command.footer(
      R"(Weigh the car first, and measure its axles. Then drive for three minutes under the camera:
circles to both sides at three speeds, and weaving as quickly as the steering follows, at
three speeds, using at most half of the grip, as odom sim --scenario exercise does. A model
with saturating tyres and lagging steering is fitted to all sensors and poses; the best
fitting parameters are the result. The stamps of the poses are the time reference of all
latencies. The inertia is that of the car with spinning wheels.

A drive determines stiffness and inertia only in proportion to the mass, so state
how precisely the car was weighed (--prior mass=0.002). Parameters that the drive
does not determine are marked, with the reason, and are not written.

Parameters (* --prior is relative); the result names their keys:)" +
      names + R"(
  mass                    * mass of the car, for --prior only [kg]

Examples:
  odom identify fit --drive lap1 --write car.toml
  odom identify fit --config car.toml --drive lap1 --write car.toml
  odom identify fit --config car.toml --drive lap1 --drive slalom --prior mass=0.002 \
    --prior yaw_inertia=0.01 --fix camera_yaw)");
}

void check(const FitOptions& o) {
  if (!(o.from >= 0.0)) refuse("--from: must not be negative");
  if (o.to != 0.0 && !(o.to - o.from >= fitting::least_duration))
    refuse("--to: must be at least ten seconds after --from");
  for (const auto& names : {o.freed, o.fixed})
    for (const std::string& name : names) static_cast<void>(fitting::parameter_named(name));
  for (const std::string& text : o.priors) static_cast<void>(fitting::parse_prior(text));
}

// The programs of odom identify fit and track are the only ones linked with large libraries.
namespace {

/// `missing` is the error if the program is not installed: how to install it.
template <class Options>
void add_program(Command identify, const std::string& name, void (*describe)(Command, Options&),
                 const std::string& missing) {
  const auto options = std::make_shared<Options>();
  const Command method = identify.add_subcommand(name);
  describe(method, *options);
  method.callback([=] {
    check(*options);
    hand_over(method, "odom-" + name, missing);
  });
}

}  // namespace

void add_track(Command identify) {
  add_program(identify, "track", describe_track,
              "films need odom-track: install the package odom-track, or libopencv-dev, and "
              "configure and build again; odom identify stiffness also accepts tracks of other "
              "programs");
}

void add_fit(Command identify) {
  add_program(identify, "fit", describe_fit,
              "fitting needs odom-fit: install the package odom-fit; or install libceres-dev, and "
              "configure and build all: cmake --preset release && cmake --build --preset release");
}

}  // namespace odomd::tools
