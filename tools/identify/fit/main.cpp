// odom-fit: odom identify fit. A separate program, so that odom itself does not depend on Ceres.
#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/command_line.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/fit/findings.hpp"
#include "tools/identify/fit/options.hpp"
#include "tools/identify/fit/solver.hpp"
#include "tools/identify/fit/trial.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::fitting {
namespace {

using estimator::Source;

// The parameters that the mapped signals can determine.
std::array<bool, parameters> free_by_default(const daemon::Config& config) {
  std::array<bool, parameters> free{};
  free.fill(true);
  if (one_imu(config)) free[accel_latency] = false;
  free[load_lag] = free[drive_spin] = false;  // hardly observable, and disturb the others
  for (const Source source : wheel_sources) free[wheel_scale(source)] = is_mapped(config, source);
  const auto any = [&](std::initializer_list<Parameter> scales) {
    return std::ranges::any_of(scales, [&](Parameter k) { return free[k]; });
  };
  const bool front = any({wheel_scale_front_left, wheel_scale_front_right});
  const bool rear_sides = any({wheel_scale_rear_left, wheel_scale_rear_right});
  free[wheel_latency_front] = front;
  free[wheel_latency_rear] = free[wheel_slip] =
      rear_sides || any({wheel_scale_rear, wheel_scale_motor});
  free[track_width] = front || rear_sides;
  if (!is_mapped(config, Source::accel_x) && !is_mapped(config, Source::accel_y))
    for (const Parameter k :
         {accel_bias_x, accel_bias_y, accel_scale, accel_latency, imu_x, imu_y, imu_yaw})
      free[k] = false;
  if (!is_mapped(config, Source::accel_x)) free[accel_bias_x] = false;
  if (!is_mapped(config, Source::accel_y)) free[accel_bias_y] = false;
  return free;
}

Settings settings_of(const daemon::Config& config, const FitOptions& options) {
  Settings result;
  result.free = free_by_default(config);
  result.prior_sigma = sigmas_of(&ParameterInfo::prior, config.vehicle.wheelbase());
  for (const std::string& name : options.freed) result.free[parameter_named(name).parameter] = true;
  for (const std::string& name : options.fixed)
    result.free[parameter_named(name).parameter] = false;
  for (const std::string& text : options.priors) {
    const Prior prior = parse_prior(text);
    (prior.parameter ? result.prior_sigma[*prior.parameter] : result.mass_sigma) = prior.sigma;
  }
  result.window = 0.5 * slowness(config);
  result.threads = options.threads;
  if (!options.quiet)
    result.progress = [](const std::string& line) { say("odom identify fit: " + line); };
  return result;
}

// A reference's poses in the form of camera poses, at least `spacing` apart: denser poses would get
// more weight than their information deserves.
std::vector<estimator::CameraPose> poses_of(const Trajectory& reference, double spacing) {
  constexpr double sigma = 0.005;  // m, rad: the residuals decide in the end
  const auto least_ns = static_cast<std::int64_t>(1e9 * spacing);
  std::vector<estimator::CameraPose> poses;
  for (const TrajectoryPoint& point : reference.points)
    if (poses.empty() || point.t_ns - poses.back().capture_ns >= least_ns)
      poses.push_back({.capture_ns = point.t_ns,
                       .arrival_ns = point.t_ns,
                       .x = point.pose.x,
                       .y = point.pose.y,
                       .yaw = point.pose.yaw,
                       .sigma_x = sigma,
                       .sigma_y = sigma,
                       .sigma_yaw = sigma});
  return poses;
}

// One bias for all drives: the mean over the drives with a standstill.
std::optional<Measured> at_rest(std::span<const fitting::FitDrive> drives) {
  std::vector<double> values;
  double sigma = std::numeric_limits<double>::infinity();
  for (const fitting::FitDrive& drive : drives) {
    if (!drive.rest) continue;
    values.push_back(drive.rest->value);
    sigma = std::min(sigma, drive.rest->sigma);
  }
  if (values.empty()) return std::nullopt;
  return Measured{mean_of(values).value, sigma};
}

tools::Drive read(const FitOptions& options, const std::string& folder) {
  tools::Drive drive =
      read_drive({.folder = folder,
                  .config = options.config,
                  .dbc = {options.dbc.begin(), options.dbc.end()},
                  .camera = options.use_reference ? CameraUse::leave_out : CameraUse::take,
                  .damage = options.damage});
  std::error_code ignored;
  if (options.use_reference && !drive.reference) refuse("{}: has no truth.csv to fit to", folder);
  if (!options.use_reference && !std::filesystem::exists(drive.folder / "camera.csv", ignored))
    refuse(
        "{}: has no camera.csv to fit to; use its truth.csv with --use-reference, or another drive",
        folder);
  drive.name = folder;
  return drive;
}

void fit(const FitOptions& options) {
  check(options);
  check(options.delivery);
  std::vector<fitting::FitDrive> drives;
  std::vector<tools::Drive> trials;
  std::optional<daemon::Config> config;  // of all drives
  diagnostics::Diagnostics warnings;
  const Part part{options.from, options.to > 0.0 ? options.to : 1e9};
  for (const std::string& folder : options.drives) {
    tools::Drive drive = read(options, folder);
    if (!config) {
      config = drive.config;
      warnings = config->warnings;
    } else if (drive.config.text != config->text) {
      refuse("{} and {} differ; give the car's configuration with --config",
             drive.config.file.string(), config->file.string());
    }
    append(warnings, drive.warnings);
    SignalLog log = signals_of(drive);
    log.name = can::log_label(drive.config.can.sources.front());
    append(warnings, log.warnings);
    std::vector<estimator::CameraPose> poses =
        options.use_reference ? poses_of(*drive.reference, least_spacing(*config)) : drive.cameras;
    check_agreement(*config, log, poses,
                    {.drive = folder,
                     .pose_source = options.use_reference ? "reference" : "camera",
                     .from = part.from,
                     .to = part.to});
    drives.push_back(prepare(folder, *config, log, poses, part));
    if (!options.untried) trials.push_back(trial_drive(std::move(drive), std::move(poses), part));
  }
  Settings settings = settings_of(*config, options);
  settings.rest = at_rest(drives);
  const Result result = solve(*config, drives, settings);
  Findings findings = findings_of(*config, drives, settings, result);
  findings.warnings.insert(findings.warnings.begin(), warnings.begin(), warnings.end());
  if (!options.untried) try_out(findings, trials, settings.progress);
  // Numbers of a fit that did not converge are only written if they improve the replay.
  const bool kept_back = !result.settled && options.untried && !options.delivery.write.empty();
  Delivery delivery = options.delivery;
  if (kept_back) delivery.write.clear();
  deliver(findings, delivery);
  if (kept_back)
    throw std::runtime_error("nothing is written to " + options.delivery.write +
                             ": the fit did not converge, and --untried skips the trial");
}

}  // namespace
}  // namespace odomd::tools::fitting

int main(int argc, char** argv) {
  odomd::tools::FitOptions options;
  const auto describe = [&options](odomd::tools::Command command) {
    command.program("odom identify fit", "odom-fit " ODOMD_VERSION);
    odomd::tools::describe_fit(command, options);
    command.callback([&options] { odomd::tools::fitting::fit(options); });
  };
  return odomd::tools::run_program(describe, argc, argv);
}
