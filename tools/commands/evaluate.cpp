// odom evaluate: errors of estimates, from pose files or whole drives.
#include <cmath>

#include <fmt/ranges.h>

#include "daemon/core/usage.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/chart/picture.hpp"
#include "tools/commands/commands.hpp"
#include "tools/diagnostics/output.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/evaluation/evaluated_drive.hpp"
#include "tools/replay/log_options.hpp"
#include "tools/report/figures.hpp"
#include "tools/report/page.hpp"

namespace odomd::tools {
namespace {

struct EvaluateOptions {
  std::string reference;
  std::vector<std::string> poses;
  std::vector<std::string> drives;
  std::vector<std::string> models;
  std::string config;
  CameraUse camera_use = CameraUse::take;
  bool closed_loop = false;
  Judging judging;
  std::vector<double> lever_arm;
  bool json = false;
  std::string html;
  std::string picture;
  std::string title;
  std::string camera;
  can::Damage damage = can::Damage::left_out;
};

Judging judging_of(const EvaluateOptions& options) {
  Judging judging = options.judging;
  if (options.closed_loop) judging.against = Against::closed_loop;
  if (!options.html.empty()) judging.judgements = Judgements::keep;
  if (!std::ranges::all_of(options.lever_arm, [](double value) { return std::isfinite(value); }))
    throw std::invalid_argument("--lever-arm: must be three finite numbers x,y,yaw");
  if (!options.lever_arm.empty())
    judging.lever_arm = {options.lever_arm[0], options.lever_arm[1], options.lever_arm[2]};
  return judging;
}

std::vector<estimator::Model> models_of(const EvaluateOptions& options) {
  std::vector<estimator::Model> models;
  for (const std::string& name : options.models) models.push_back(daemon::parse_model(name));
  return models;
}

std::vector<EvaluatedDrive> evaluated(const EvaluateOptions& options) {
  const Judging judging = judging_of(options);
  std::vector<EvaluatedDrive> drives;
  if (!options.poses.empty()) {
    drives.push_back(evaluate_files(options.reference, options.poses, judging));
    if (!options.camera.empty()) {
      CameraLog log = read_camera_log(options.camera);
      drives.front().cameras = std::move(log.poses);
      append(drives.front().warnings, log.warnings);
    }
  }
  for (const std::string& folder : options.drives) {
    drives.push_back(evaluate_folder({.folder = folder,
                                      .config = options.config,
                                      .reference = options.reference,
                                      .camera = options.camera_use,
                                      .damage = options.damage},
                                     models_of(options), judging));
  }
  if (drives.size() > 1) {
    const std::vector<std::string> names = names_side_by_side(options.drives);
    for (std::size_t i = 0; i < drives.size(); ++i) drives[i].name = names[i];
  }
  return drives;
}

// The report on a single drive, with the samples of its last model, the best one.
std::string details_of(const EvaluatedDrive& drive) {
  return as_text(drive.report) + "\nsamples of " + drive.estimates.back().name +
         (drive.is_part ? ", over the whole drive" : "") + "\n\n" +
         source_table(drive.replays.back().summary).text();
}

nlohmann::ordered_json files_json(const EvaluatedDrive& drive) {
  nlohmann::ordered_json json = json_of(drive.report);
  json["warnings"] = texts_of(drive.warnings);
  json["diagnostics"] = as_json(drive.warnings);
  json["verdict"] = report::as_json(report::verdict_of(drive));
  return json;
}

std::vector<std::filesystem::path> inputs_of(const EvaluateOptions& options) {
  std::vector<std::filesystem::path> inputs{options.reference, options.camera,
                                            options.judging.beat};
  inputs.insert(inputs.end(), options.poses.begin(), options.poses.end());
  for (const std::string& folder : options.drives) {
    const auto files =
        files_of({.folder = folder, .config = options.config, .reference = options.reference});
    inputs.insert(inputs.end(), files.begin(), files.end());
  }
  return inputs;
}

nlohmann::ordered_json drives_json(const std::vector<EvaluatedDrive>& drives) {
  nlohmann::ordered_json json = summary_json(drives);
  for (std::size_t i = 0; i < drives.size(); ++i)
    json["drives"][i]["verdict"] = report::as_json(report::verdict_of(drives[i]));
  return json;
}

// One drive: all its details. Several: the table, and for each drive its verdict and main reason.
std::string drives_text(const std::vector<EvaluatedDrive>& drives) {
  const std::string table = summary_table(drives).text();
  if (drives.size() == 1)
    return details_of(drives.front()) + '\n' + table +
           "\nverdict: " + report::as_text(report::verdict_of(drives.front()));
  std::string text = table + '\n';
  for (const EvaluatedDrive& drive : drives) {
    const report::DriveVerdict verdict = report::verdict_of(drive);
    text += fmt::format("{}: {}: {}\n", drive.name, report::in_words(verdict.grade),
                        verdict.reasons.front().sentence);
    if (drive.report.evaluations.front().against != Against::reference)
      text += fmt::format("  reference {}\n", verdict.basis);
  }
  return text;
}

// One drive: its trajectories. Several: their errors against speed.
void write_picture_of(const std::vector<EvaluatedDrive>& drives, const EvaluateOptions& options) {
  const std::vector<chart::Drawing> drawings =
      drives.size() == 1 ? std::vector{draw(evaluation_map(drives.front(), options.title))}
                         : errors_by_speed(drives);
  chart::write_picture(options.picture, drawings);
}

void run_evaluate(const EvaluateOptions& options) {
  check_outputs(
      std::vector<Output>{
          {"the summary", "-"}, {"--html", options.html}, {"--picture", options.picture}},
      inputs_of(options));
  const std::vector<EvaluatedDrive> drives = evaluated(options);
  if (options.closed_loop && options.judging.frame == Frame::map &&
      std::ranges::any_of(drives,
                          [](const EvaluatedDrive& drive) { return camera_came_in(drive); }))
    std::cerr << "odom evaluate: warning: --closed-loop with camera poses: the error at the end is "
                 "only as good as the camera; use --dead-reckoning to evaluate the odometry\n";
  for (const EvaluatedDrive& drive : drives)  // warnings about pose files contain their names
    warn("evaluate", drive.warnings, drive.replays.empty() ? "" : drive.name);
  if (!options.picture.empty()) write_picture_of(drives, options);
  if (!options.html.empty()) {
    write_whole(options.html, report::page(drives, {.title = options.title,
                                                    .version = ODOMD_VERSION,
                                                    .command = given_command()}));
  }
  if (options.json) {
    const auto json = options.drives.empty() ? files_json(drives.front()) : drives_json(drives);
    std::cout << json_text(json, 2) << '\n';
  } else if (options.drives.empty()) {
    std::cout << as_text(drives.front().report)
              << "\nverdict: " << report::as_text(report::verdict_of(drives.front()));
  } else {
    std::cout << drives_text(drives);
  }
}

// Checks dependencies between options; errors read like those of CLI11.
void check(const EvaluateOptions& options) {
  if (options.poses.empty() && options.drives.empty()) {
    require("--pose or --drive");
  }
  if (!options.poses.empty() && options.reference.empty() && !options.closed_loop) {
    require("--reference (or --closed-loop)");
  }
  if (options.drives.size() > 1 && !options.reference.empty()) {
    throw std::invalid_argument(
        "--reference: is for one drive only; put truth.csv into each folder");
  }
  if (options.drives.size() > 1 && !options.judging.beat.empty()) {
    throw std::invalid_argument("--beat: is for one drive only; put beat.csv into each folder");
  }
}

void add_inputs(Command command, EvaluateOptions& options) {
  command.add(
      "--reference", "CSV", options.reference,
      "Reference with the columns t,x,y,yaw; with --drive, it replaces the truth.csv of the drive");
  command.add("--pose", "CSV", options.poses,
              "Poses in the format of odom replay; repeatable, compared side by side",
              {repeatable()});
  command.add("--drive,DIR", "DIR", options.drives,
              "Folder with drive.log (or can.log), car.toml, and truth.csv or "
              "camera.csv, to replay; repeatable",
              {excludes("--pose")});
  command.add(
      "--model", fmt::format("{}", fmt::join(estimator::model_names, "|")), options.models,
      "Model for the replay; repeatable; default: kinematic, paper, inertial (if there is a "
      "gyro), full",
      {repeatable(), needs("--drive")});
  command.add("--config", "FILE", options.config,
              "Configuration of the car (TOML); replaces the drive's car.toml. A database that "
              "does not exist where it says is taken from the drive's folder",
              {needs("--drive")});
  command.add_flag("--dead-reckoning", options.camera_use, CameraUse::leave_out,
                   "Evaluate dead reckoning: leave out the camera poses", {needs("--drive")});
  command.add_flag(
      "--closed-loop", options.closed_loop,
      "Without a reference, for a drive that ends where it began: the error is the distance "
      "between start and end. With camera poses, this is only as accurate as the camera",
      {excludes("--reference")});
}

void add_judging(Command command, EvaluateOptions& options) {
  command.add_choice("--align", options.judging.align,
                     {{"first", Align::first}, {"fit", Align::fit}, {"none", Align::none}},
                     "Alignment: at the first common time, least-squares fit, or none; default: "
                     "none for the map pose of a drive with camera poses, otherwise first");
  command.add_choice(
      "--frame", options.judging.frame, {{"map", Frame::map}, {"odom", Frame::odom}},
      "Frame of the pose: the map, or the odometry frame without jumps; default: map");
  command.add("--from", "T|+T", options.judging.from,
              "Start time [s] on the files' clock; +T: relative to the first row of the reference");
  command.add("--to", "T|+T", options.judging.to,
              "End time [s] on the files' clock; +T: relative to the first row of the reference");
  command.add("--lever-arm", "X,Y,YAW", options.lever_arm,
              "Pose of the reference point in the body frame [m, m, rad]; default: 0; with "
              "--drive: [reference] lever_arm, otherwise that of the camera",
              {delimiter(','), values(3)});
  command.add_flag("--fit-lever-arm", options.judging.fit_lever_arm,
                   "Fit one lever arm to all estimates", {excludes("--lever-arm")});
  command.add(
      "--baseline", "ESTIMATE", options.judging.baseline,
      "Estimate that the others are compared with; default: kinematic, otherwise the first");
}

void add_outputs(Command command, EvaluateOptions& options) {
  command.add_flag("--json", options.json, "Print the result as JSON, in SI units");
  command.add("--html", "FILE", options.html, "Write a self-contained report with pictures");
  command.add("--beat", "CSV", options.judging.beat,
              "Timing of the ticks (beat.csv of a recording), for the report; with --drive, it "
              "replaces that of the drive",
              {needs("--html")});
  command.add("--picture", "FILE", options.picture,
              "Draw the trajectories into a file, .svg or .png; for several drives, draw the "
              "errors against the mean speed");
  command.add("--title", "TEXT", options.title, "Title of report and picture");
  command.add("--camera", "CSV", options.camera, "Camera log to draw as dots",
              {excludes("--drive")});
  add_strict(command, options.damage);
}

}  // namespace

void add_evaluate(Command odom) {
  Command command = odom.add_subcommand(
      "evaluate", "Compare poses with a reference, or several models on whole drives");
  auto options = std::make_shared<EvaluateOptions>();
  add_inputs(command, *options);
  add_judging(command, *options);
  add_outputs(command, *options);
  command.footer(
      "Examples:\n"
      "  odom evaluate --reference truth.csv --pose pose.csv\n"
      "  odom evaluate --reference truth.csv --pose kinematic.csv --pose paper.csv --json\n"
      "  odom evaluate --reference truth.csv --pose pose.csv --align fit --picture lap.svg\n"
      "  odom evaluate --reference mocap.csv --pose pose.csv --fit-lever-arm\n"
      "  odom evaluate --reference truth.csv --pose pose.csv --from +15 --to +25 --frame odom\n"
      "  odom evaluate --drive lap --dead-reckoning --html lap.html\n"
      "  odom evaluate --drive monday --drive tuesday --model kinematic --model full\n"
      "  odom evaluate --drive drive-20261121-140300 --closed-loop --dead-reckoning\n"
      "Only times that both cover are used; the reference is interpolated, never extrapolated.\n"
      "A drive is replayed as by odom replay, and its models are evaluated like pose files. Its\n"
      "reference is its truth.csv; otherwise its camera.csv; otherwise its start, if the car\n"
      "came back there. Without a reference there are no errors, only innovations.\n\n" +
      std::string(daemon::models_help));
  command.callback([options] {
    check(*options);
    run_evaluate(*options);
  });
}

}  // namespace odomd::tools
