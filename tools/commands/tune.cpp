// odom tune: better settings, found by replaying drives on all cores.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "daemon/core/usage.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/choice.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/json_text.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/progress.hpp"
#include "tools/cli/text.hpp"
#include "tools/commands/commands.hpp"
#include "tools/config_patch/config_patch.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/evaluation/drive_checks.hpp"
#include "tools/evaluation/evaluation_report.hpp"
#include "tools/tune/config_difference.hpp"
#include "tools/tune/tune_report.hpp"
#include "tools/tune/tuning.hpp"

namespace odomd::tools {
namespace {

struct Options {
  std::vector<std::string> drives;
  std::vector<std::string> held_out;
  std::string config;
  std::vector<std::string> set;
  std::vector<std::string> goals;
  std::string model;
  std::optional<Align> align;
  std::vector<double> lever_arm;
  bool no_camera = false;
  std::size_t trials = SearchSettings{}.trials;
  std::size_t jobs = 0;
  std::string state;
  std::string out;
  std::string write;
  bool force = false;
  bool json = false;
};

std::vector<Drive> read_drives(const std::vector<std::string>& folders, const Options& options) {
  std::vector<Drive> drives;
  for (const std::string& folder : folders) {
    drives.push_back(
        read_drive({.folder = folder,
                    .config = options.config,
                    .reference = {},
                    .camera = options.no_camera ? CameraUse::leave_out : CameraUse::take}));
    const Drive& drive = drives.back();
    warn("tune", drive.config.warnings, folder);
    warn("tune", drive.warnings, folder);
    if (drive.reference) continue;
    find_reference(drives.back());
    if (drive.reference && !options.lever_arm.empty())
      throw std::invalid_argument(folder +
                                  ": --lever-arm is of a truth.csv; without one the reference is "
                                  "camera.csv with [camera] lever_arm");
    if (drive.reference && std::ranges::any_of(options.set, [](const std::string& key) {
          return key.starts_with("camera.lever_arm");
        }))
      throw std::invalid_argument(folder +
                                  ": --set camera.lever_arm needs a truth.csv: the reference is "
                                  "camera.csv by the lever arm itself");
    say("odom tune: " + folder + ": reference " +
        basis_in_words(drive.reference     ? Against::camera
                       : drive.closed_loop ? Against::closed_loop
                                           : Against::nothing));
  }
  return drives;
}

std::vector<std::filesystem::path> inputs_of(const Options& options) {
  std::vector<std::filesystem::path> inputs;
  for (const auto* folders : {&options.drives, &options.held_out})
    for (const std::string& folder : *folders) {
      const auto files = files_of({.folder = folder, .config = options.config, .reference = {}});
      inputs.insert(inputs.end(), files.begin(), files.end());
    }
  return inputs;
}

Goal goal_named(const std::string& name) {
  const auto* const found = std::ranges::find(goal_names, name);
  if (found == goal_names.end())
    throw std::invalid_argument(
        "--goal: \"" + name +
        "\" is none of position, heading, prediction, second, end, nees, nis");
  return static_cast<Goal>(found - goal_names.begin());
}

TuneJob job_of(const Options& options) {
  TuneJob job;
  for (const std::string& text : options.set) {
    Parameter parameter = parse_parameter(text);
    for (const Parameter& other : job.parameters)
      if (other.key == parameter.key)
        throw std::invalid_argument("--set: " + parameter.key + " is named twice");
    job.parameters.push_back(std::move(parameter));
  }
  for (const std::string& name : options.goals) job.goals.push_back(goal_named(name));
  if (job.goals.empty()) {
    job.goals_if_known = {Goal::position, Goal::heading, Goal::prediction, Goal::nees};
    job.goals_else = {Goal::end, Goal::nis};
  }
  const auto is_same = [](const std::string& one, const std::string& other) {
    std::error_code missing;  // which the reader reports
    return std::filesystem::equivalent(one, other, missing);
  };
  for (const std::string& held_out : options.held_out)
    for (const std::string& drive : options.drives)
      if (is_same(held_out, drive))
        throw std::invalid_argument("--held-out " + held_out +
                                    ": is also given with --drive; give it only once");
  if (!options.model.empty()) job.model = daemon::parse_model(options.model);
  job.measure.align = options.align;
  for (const double value : options.lever_arm)
    if (!std::isfinite(value))
      throw std::invalid_argument("--lever-arm: must be three finite numbers x,y,yaw");
  if (!options.lever_arm.empty())
    job.measure.lever_arm = {options.lever_arm[0], options.lever_arm[1], options.lever_arm[2]};
  job.threads = options.jobs != 0 ? options.jobs
                                  : std::max<std::size_t>(std::thread::hardware_concurrency(), 1);
  job.search.trials = options.trials;
  if (options.force) job.worse_goals = WorseGoals::allowed;
  job.state = options.state;
  job.drives = read_drives(options.drives, options);
  job.held_out = read_drives(options.held_out, options);
  std::vector<std::string> folders = options.drives;
  folders.insert(folders.end(), options.held_out.begin(), options.held_out.end());
  const std::vector<std::string> names = names_side_by_side(folders);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t tuned_on = job.drives.size();
    (i < tuned_on ? job.drives[i] : job.held_out[i - tuned_on]).name = names[i];
  }
  return job;
}

std::string in_words(const TuneProgress& progress) {
  return fmt::format("{}, {} of {} replays of this round, best {:.1f} % better",
                     counted(progress.trials, "trial"), progress.done, progress.all,
                     100.0 * (1.0 - progress.best));
}

void warn_of_drives(const TuneJob& job) {
  for (const auto* drives : {&job.drives, &job.held_out})
    for (const Drive& drive : *drives) {
      if (!drive.reference) continue;
      daemon::Config config = drive.config;
      config.model = job.model.value_or(config.model);
      try {
        warn("tune", check_drive(drive, config, job.measure), drive.folder.string());
      } catch (const std::invalid_argument&) {  // no pose: the search reports it
      }
    }
}

void warn_of_other_config(const TuneJob& job, const Options& options) {
  if (options.write.empty()) return;
  const daemon::Config written = daemon::load_config(options.write);
  for (const Drive& drive : job.drives) {
    std::string difference = config_difference(drive.config, written, job.parameters);
    // --model is a choice of its own.
    if (!job.model && drive.config.model != written.model)
      difference =
          fmt::format("filter.model ({}, {}){}{}", daemon::name_of(drive.config.model),
                      daemon::name_of(written.model), difference.empty() ? "" : ", ", difference);
    if (difference.empty()) continue;
    say("odom tune: warning: the search runs with " + drive.config.file.string() +
        ", which differs from " + options.write + ": " + difference +
        "; the result may not suit it: search with --config " + options.write);
    if (!options.config.empty()) return;  // of all drives
  }
}

/// "filter.wheel_slip 0.02 > 0.011": the file's value, or the default, before and after.
std::string change(const std::string& file, const TunedKey& key) {
  std::optional<double> before = number_in(file, key.key);
  if (!before) before = key.before;
  return fmt::format("{} {} > {}", key.key, before ? shortest(*before) : "none",
                     shortest(key.after));
}

void write_config(const Options& options, const TuneJob& job, const TuneResult& result) {
  if (!result.is_better() && !(options.force && result.is_better_here())) {
    say("odom tune: " + options.write + " is unchanged" +
        (result.is_better_here() ? "; --force writes it nevertheless" : ""));
    return;
  }
  std::vector<ConfigValue> values;
  std::string written;
  for (const TunedKey& key : result.keys) {
    if (key.fate != Fate::taken) continue;
    values.push_back({key.key, key.after, note_of(job, result, key)});
    written += (written.empty() ? "" : ", ") + change(options.write, key);
  }
  patch_config(options.write, values);
  say("odom tune: " + counted(values.size(), "key") + " written to " + options.write + ": " +
      written);
}

void run_tune(const Options& options) {
  if (!options.out.empty()) check_writable(options.out);
  // Output that cannot be written is reported before the work starts.
  if (!options.write.empty()) check_patchable(options.write);
  check_outputs(
      std::vector<Output>{
          {"--write", options.write}, {"--state", options.state}, {"--out", options.out}},
      {});
  check_outputs(std::vector<Output>{{"--state", options.state}, {"--out", options.out}},
                inputs_of(options));
  const TuneJob job = job_of(options);
  warn_of_drives(job);
  warn_of_other_config(job, options);
  std::optional<WholeFile> trials;
  if (!options.out.empty()) trials.emplace(options.out);
  Interrupt interrupt;
  ProgressLine progress("odom tune");
  TuneResult result;
  try {
    result = tune(job, [&](const TuneProgress& now) {
      progress.show(in_words(now));
      return interrupt.requested() ? GoOn::no : GoOn::yes;
    });
  } catch (const Stopped&) {
    progress.end();
    throw std::runtime_error(
        options.state.empty()
            ? "stopped; with --state FILE the next run would continue from here"
            : "stopped; the same command continues from here with " + options.state);
  }
  progress.end();
  if (trials) {
    trials->stream() << trials_csv(job, result);
    trials->finish();
  }
  std::cout << (options.json ? as_json(result) : as_text(job, result));
  if (!options.write.empty()) write_config(options, job, result);
}

}  // namespace

void add_tune(Command odom) {
  Command command = odom.add_subcommand(
      "tune", "Search for settings that reduce the errors of drives, and report over-fitting");
  const auto options = std::make_shared<Options>();
  command
      .add_option(
          "--drive", options->drives,
          "Drive to tune on: a folder with drive.log (or can.log), car.toml, and truth.csv or "
          "camera.csv; repeatable")
      .required()
      .repeatable()
      .type_name("DIR");
  command
      .add_option("--held-out", options->held_out,
                  "Drive to validate on: the search does not use it; repeatable")
      .repeatable()
      .type_name("DIR");
  command
      .add_option("--set", options->set,
                  "Parameter to tune: KEY=FROM:TO is searched, KEY=FROM:TO:N and KEY=A,B,C are "
                  "swept in all combinations; repeatable")
      .required()
      .repeatable()
      .type_name("KEY=RANGE");
  command
      .add_option("--config", options->config,
                  "Configuration of the car (TOML); instead of each drive's car.toml")
      .type_name("TOML");
  command
      .add_option(
          "--goal", options->goals,
          "Objectives, of position, heading, prediction (35 ms), second (1 s), end (cm/m), nees, "
          "nis; default: those of position, heading, prediction, nees that the drives allow, else "
          "end, else nis")
      .delimiter(',')
      .type_name("NAMES");
  command.add_option("--model", options->model, "Model of the filter; instead of [filter] model")
      .type_name("MODEL");
  add_choice<std::optional<Align>>(
      command, "--align", options->align,
      {{"first", Align::first}, {"fit", Align::fit}, {"none", Align::none}},
      "Alignment with the reference, as in odom evaluate; default: none for a drive with camera "
      "poses, else first");
  command
      .add_option("--lever-arm", options->lever_arm,
                  "Pose of the reference's point in the body frame [m, m, rad]; default: "
                  "[reference] lever_arm, else the camera's")
      .delimiter(',')
      .values(3)
      .type_name("X,Y,YAW");
  command.add_flag("--no-camera", options->no_camera,
                   "Leave the camera's poses out: dead reckoning");
  command
      .add_option("--trials", options->trials, "Maximum number of trials in a search; default: 400")
      .within(1, 1'000'000)
      .type_name("N");
  command.add_option("--jobs", options->jobs, "Parallel replays; default: one per core")
      .within(1, 1024)
      .type_name("N");
  command
      .add_option("--state", options->state,
                  "File with the trials; a stopped run continues from it")
      .type_name("FILE");
  command.add_option("--out", options->out, "Table of every trial: keys and relative error")
      .type_name("CSV");
  command
      .add_option("--write", options->write,
                  "Configuration to write the tuned values to, if they reduce the error, also on "
                  "the held-out drives, and worsen no goal")
      .type_name("TOML");
  command.add_flag(
      "--force", options->force,
      "Search for and write the smallest error, even if a goal or the held-out drives get worse");
  command.add_flag("--json", options->json, "Print the result as JSON");
  command.footer(
      "Every error is divided by the same error with the present configuration; the geometric\n"
      "mean over drives and goals is minimised, below 1 is better. Ranges above zero are searched\n"
      "on a logarithmic scale. A key that helps the drives tuned on and harms those held out is\n"
      "over-fitted, and keeps its value. A drive without truth.csv is judged by its camera.csv,\n"
      "else as a closed loop if it ends where it began, else by its innovations (nis).\n"
      "\n" +
      std::string(daemon::models_help) +
      "\n\n"
      "Examples:\n"
      "  odom tune --drive lap1 --drive lap2 --held-out lap3 \\\n"
      "    --set filter.front_angle_error=0.01:0.2 \\\n"
      "    --set can.signals.yaw_rate.sigma=0.002:0.05 --state tune.state --write car.toml\n"
      "  odom tune --drive lap1 --set filter.wheel_slip=0.005:0.08:9 --out sweep.csv\n"
      "  odom tune --drive lap1 --no-camera --goal end,heading \\\n"
      "    --set vehicle.yaw_inertia=0.02:0.04");
  command.callback([options] { run_tune(*options); });
}

}  // namespace odomd::tools
