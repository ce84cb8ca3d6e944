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
#include "tools/drive_files/camera_csv.hpp"
#include "tools/drive_files/trajectory.hpp"
#include "tools/identify/common/agreement.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/common/refuse.hpp"
#include "tools/identify/fit/findings.hpp"
#include "tools/identify/fit/options.hpp"
#include "tools/identify/fit/solver.hpp"
#include "tools/identify/fit/trial.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::fitting {
namespace {

namespace fs = std::filesystem;
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

struct Priors {
  Settings settings;
  double mass = 0.01;
};

Priors priors_of(const daemon::Config& config, const FitOptions& options) {
  Priors result;
  result.settings.free = free_by_default(config);
  result.settings.prior_sigma = sigmas_of(&ParameterInfo::prior, config.vehicle.wheelbase());
  for (const std::string& name : options.freed)
    result.settings.free[parameter_named(name).parameter] = true;
  for (const std::string& name : options.fixed)
    result.settings.free[parameter_named(name).parameter] = false;
  for (const std::string& text : options.priors) {
    const Prior prior = parse_prior(text);
    (prior.parameter ? result.settings.prior_sigma[*prior.parameter] : result.mass) = prior.sigma;
  }
  result.settings.window = 0.5 * slowness(config);
  result.settings.threads = options.threads;
  if (!options.quiet)
    result.settings.progress = [](const std::string& line) { say("odom identify fit: " + line); };
  return result;
}

std::vector<estimator::CameraPose> poses_of_reference(const std::string& file, double spacing) {
  constexpr double sigma = 0.005;  // m, rad: the residuals decide in the end
  std::vector<estimator::CameraPose> poses;
  for (const TrajectoryPoint& point : read_trajectory(file).points) {
    estimator::CameraPose pose;
    pose.capture_ns = pose.arrival_ns = point.t_ns;
    pose.x = point.pose.x;
    pose.y = point.pose.y;
    pose.yaw = point.pose.yaw;
    pose.sigma_x = pose.sigma_y = pose.sigma_yaw = sigma;
    // Denser poses would get more weight than their information deserves.
    const auto least = static_cast<std::int64_t>(1e9 * spacing);
    if (!poses.empty() && pose.capture_ns - poses.back().capture_ns < least) continue;
    poses.push_back(pose);
  }
  return poses;
}

// One bias for all drives: the mean over the drives with a standstill.
std::optional<Measured> at_rest(std::span<const fitting::Drive> drives) {
  std::vector<double> values;
  double sigma = std::numeric_limits<double>::infinity();
  for (const fitting::Drive& drive : drives) {
    if (!drive.rest) continue;
    values.push_back(drive.rest->value);
    sigma = std::min(sigma, drive.rest->sigma);
  }
  if (values.empty()) return std::nullopt;
  return Measured{mean_of(values).value, sigma};
}

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

// The configuration of all drives: drives with different ones are refused.
daemon::Config config_of(const FitOptions& options) {
  if (!options.config.empty()) return daemon::load_config(options.config);
  std::optional<daemon::Config> config;
  for (const std::string& drive : options.drives) {
    check_folder(drive);
    const fs::path file = fs::path(drive) / "car.toml";
    if (!is_there(file))
      refuse("{}: has no car.toml; give the car's configuration with --config", drive);
    daemon::Config own = daemon::load_config(file);
    if (config && own.text != config->text)
      refuse("{} and {} differ; give the car's configuration with --config", file.string(),
             config->file.string());
    if (!config) config = std::move(own);
  }
  return std::move(config).value();
}

std::string poses_in(const std::string& folder, bool use_reference) {
  const fs::path poses = fs::path(folder) / (use_reference ? "truth.csv" : "camera.csv");
  if (!is_there(poses))
    throw std::invalid_argument(
        folder + (use_reference ? ": has no truth.csv to fit to"
                                : ": has no camera.csv to fit to; use its truth.csv with "
                                  "--use-reference, or another drive"));
  return poses.string();
}

void fit(const FitOptions& options) {
  check(options);
  check(options.delivery);
  daemon::Config config = config_of(options);
  if (!options.dbc.empty()) config.can.dbc.assign(options.dbc.begin(), options.dbc.end());
  Priors priors = priors_of(config, options);

  diagnostics::Diagnostics warnings = config.warnings;
  std::vector<fitting::Drive> drives;
  std::vector<tools::Drive> trials;
  const Part part{options.from, options.to > 0.0 ? options.to : 1e9};
  for (const std::string& folder : options.drives) {
    check_folder(folder);
    const std::vector<std::string> logs{need_log_in(folder).string()};
    const std::string file = poses_in(folder, options.use_reference);
    const SignalLog log = read_signals(config, logs, options.damage);
    append(warnings, log.warnings);
    std::vector<estimator::CameraPose> poses;
    if (options.use_reference) {
      poses = poses_of_reference(file, least_spacing(config));
    } else {
      CameraLog camera = read_camera_log(file);
      append(warnings, camera.warnings);
      poses = std::move(camera.poses);
    }
    check_agreement(config, log, poses,
                    {.drive = folder,
                     .pose_source = options.use_reference ? "reference" : "camera",
                     .from = part.from,
                     .to = part.to});
    drives.push_back(prepare(folder, config, log, poses, part));
    if (!options.untried)
      trials.push_back(trial_drive(folder, config, logs, std::move(poses), part.from, part.to));
  }
  priors.settings.rest = at_rest(drives);
  const Result result = solve(config, drives, priors.settings);
  Findings findings = findings_of(config, drives, priors.settings, result, priors.mass);
  findings.warnings.insert(findings.warnings.begin(), warnings.begin(), warnings.end());
  if (!options.untried) try_out(findings, trials, priors.settings.progress);
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
