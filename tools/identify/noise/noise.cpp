// odom identify noise: the noise of sensors at rest, and the filter's noise settings from a drive.
#include <memory>
#include <optional>
#include <string>

#include "tools/chart/picture.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/record.hpp"
#include "tools/identify/common/refuse.hpp"
#include "tools/identify/methods.hpp"
#include "tools/identify/noise/noise_findings.hpp"
#include "tools/replay/drive.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {
namespace {

struct Options {
  RecordOptions standing;
  std::string drive;
  std::string plot;
  bool no_camera = false;
  Delivery delivery;
};

Findings identify_noise(const Options& options) {
  const bool standing = is_given(options.standing);
  if (!standing && options.drive.empty())
    refuse(
        "give a record of the standing car, --config and --can or --csv, a drive, --drive, or "
        "both; odom identify noise --help explains each");
  if (!options.plot.empty()) {
    if (!standing) refuse("--plot draws a standing record; give one with --can or --csv");
    chart::check_picture(options.plot);
  }
  if (!options.drive.empty()) check_folder(options.drive);
  std::optional<daemon::Config> config;
  for (const std::string& file :
       {options.standing.config, options.delivery.write,
        options.drive.empty() ? std::string{} : options.drive + "/car.toml"})
    if (!config && !file.empty()) config = daemon::load_config(file);
  Findings findings{.method = "noise"};
  if (standing) {
    add_standing_findings(options.standing, options.plot, config, findings);
    findings.origin = "standing";
  }
  if (!options.drive.empty()) {
    add_driving_findings({.folder = options.drive,
                          .config = options.standing.config,
                          .reference = {},
                          .camera = options.no_camera ? CameraUse::leave_out : CameraUse::take,
                          .damage = options.standing.damage},
                         config, findings);
    findings.origin += (standing ? " and " : "") + std::string("driving");
  }
  return findings;
}

}  // namespace

void add_noise(Command identify) {
  const auto options = std::make_shared<Options>();
  Command method = identify.add_subcommand(
      "noise",
      "Measure the noise of gyro and accelerometers, and the filter's, standing and driving");
  method.footer(
      R"(Standing: let the car stand where nothing shakes it, motor on, warm, and log its IMU for
ten minutes; an hour also shows the bias's walk. From it come the white noise of a sample
and its density, bias, random walk and instability of the bias, by maximum likelihood and
by the Allan deviation, which --plot draws. With --config the variance that the paper's
filter gives v_x in a step (filter.paper_q) is checked. It must exceed dt^2 sigma^2 of a
sample of a_x, or dt S where S is a density (errata 9 in docs/model.md: the paper prints
dt sigma^2); otherwise the filter trusts the accelerometer too much.

Driving: a folder of odom sim or odom record, with turns of all kinds, best
with a camera. From it come the noise of each moving sensor (R), which vibration makes
larger than at rest, and the process noise (Q) at which the innovations of the full
filter are as large as it expects: a mean normalised innovation squared (NIS) of 1.
Identify the parameters first: a wrong stiffness or latency looks like noise.

Examples:
  odom identify noise --config car.toml --can standing.log --plot allan.svg
  odom identify noise --csv phone.csv --from 10 --to 600
  odom identify noise --drive lap --write car.toml
  odom identify noise --config car.toml --can standing.log --drive lap --write car.toml)");
  const Command standing = method.group("Standing"), driving = method.group("Driving");
  add_record_options(standing, options->standing);
  standing.add("--plot", "FILE", options->plot, "Draw the Allan deviation, .svg or .png");
  driving.add("--drive,DIR", "DIR", options->drive,
              "Folder of a drive, from odom sim or odom record");
  driving.add_flag("--no-camera", options->no_camera,
                   "Leave the camera's poses out: dead reckoning");
  add_delivery(method, options, identify_noise);
  add_strict(method, options->standing.damage);
}

}  // namespace odomd::tools
