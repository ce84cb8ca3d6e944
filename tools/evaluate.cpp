// odom evaluate: how good estimates are against a reference.
#include <array>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/camera_csv.hpp"
#include "tools/choice.hpp"
#include "tools/commands.hpp"
#include "tools/csv.hpp"
#include "tools/evaluation.hpp"
#include "tools/evaluation_map.hpp"
#include "tools/evaluation_report.hpp"
#include "tools/text.hpp"

namespace odomd::tools {
namespace {

struct Options {
  std::string reference;
  std::vector<std::string> poses;
  Align align = Align::first;
  Frame frame = Frame::map;
  std::string from;
  std::string to;
  std::vector<double> lever_arm;
  bool fit_lever_arm = false;
  bool json = false;
  std::string picture;
  std::string title;
  std::string camera;
};

void warn(const std::string& text) {
  std::cerr << "odom evaluate: warning: " << text << '\n';
}

void warn_of_doubts(const std::vector<Evaluation>& evaluations) {
  constexpr std::int64_t long_gap_ns = 200'000'000;
  const Evaluation& first = evaluations.front();
  for (const Evaluation& e : evaluations) {
    if (e.reference_gap_ns > long_gap_ns) {
      warn(e.name + ": the reference has a gap of " +
           fixed(static_cast<double>(e.reference_gap_ns) * 1e-9, 2) +
           " s, bridged by a straight line");
    }
    if (e.reference_jumps > 0) {
      warn(e.name + ": the reference jumps " + std::to_string(e.reference_jumps) +
           " times faster than any car (100 m/s); path length, maxima and 35 ms errors hold these "
           "jumps");
    }
    if (e.first_ns != first.first_ns || e.last_ns != first.last_ns) {
      warn(e.name + ": its common time differs from that of " + first.name +
           "; their numbers compare with care");
    }
  }
}

// "1760000015.5" is a time of the files, "+15.5" one after the first row of the reference.
std::optional<std::int64_t> time_of(const std::string& option, const std::string& text,
                                    std::int64_t first_ns) {
  if (text.empty()) return std::nullopt;
  const bool relative = text.front() == '+';
  const auto seconds = parse_seconds(std::string_view{text}.substr(relative ? 1 : 0));
  std::int64_t time_ns = seconds.value_or(0);
  if (!seconds || (relative && __builtin_add_overflow(first_ns, *seconds, &time_ns))) {
    throw std::invalid_argument(option + ": " + tools::quoted(text) +
                                " is not a time in seconds, such as 1760000015.5 (of the files) "
                                "or +15.5 (after the reference's first row)");
  }
  return time_ns;
}

Trajectory read_estimate(const std::string& file, const Options& options,
                         const Trajectory& reference) {
  Trajectory estimate = read_trajectory(file, options.frame);
  const std::int64_t first_ns = reference.points.front().t_ns;
  const auto from = time_of("--from", options.from, first_ns);
  const auto to = time_of("--to", options.to, first_ns);
  if (!from && !to) return estimate;
  using Limits = std::numeric_limits<std::int64_t>;
  return cut_to(std::move(estimate), from.value_or(Limits::min()), to.value_or(Limits::max()));
}

void run_evaluate(const Options& options) {
  Trajectory reference = read_trajectory(options.reference);
  std::vector<Trajectory> estimates;
  for (const auto& file : options.poses)
    estimates.push_back(read_estimate(file, options, reference));
  for (const auto& text : reference.warnings) warn(text);
  for (const auto& estimate : estimates) {
    for (const auto& text : estimate.warnings) warn(text);
  }

  EvaluationReport report;
  report.reference = options.reference;
  report.align = options.align;
  report.frame = options.frame;
  if (!options.lever_arm.empty()) {
    for (const double value : options.lever_arm) {
      if (!std::isfinite(value)) {
        throw std::invalid_argument("--lever-arm: must be three finite numbers x,y,yaw");
      }
    }
    report.lever_arm = {options.lever_arm[0], options.lever_arm[1], options.lever_arm[2]};
  } else if (options.fit_lever_arm) {
    const LeverArmFit fit = fit_lever_arm(reference, estimates);
    report.lever_arm = fit.lever_arm;
    report.fitted_windows = fit.windows;
  }
  if (report.lever_arm) reference = at_centre_of_gravity(reference, *report.lever_arm);

  for (const auto& estimate : estimates) {
    report.evaluations.push_back(evaluate(reference, estimate, options.align));
  }
  warn_of_doubts(report.evaluations);

  if (!options.picture.empty()) {
    std::vector<estimator::CameraPose> camera;
    if (!options.camera.empty()) {
      CameraLog log = read_camera_log(options.camera);
      for (const auto& text : log.warnings) warn(text);
      camera = std::move(log.poses);
    }
    chart::write_picture(options.picture,
                         std::array{draw(evaluation_map(reference, estimates, report.evaluations,
                                                        camera, options.title))});
  }
  std::cout << (options.json ? as_json(report) : as_text(report));
}

}  // namespace

void add_evaluate(CLI::App& odom) {
  auto* command = odom.add_subcommand("evaluate", "Compare poses with a reference trajectory");
  auto options = std::make_shared<Options>();
  command->add_option("--reference", options->reference, "The truth, with the columns t,x,y,yaw")
      ->required()
      ->type_name("CSV");
  command
      ->add_option("--pose", options->poses,
                   "Poses, as odom replay writes them; several times: side by side")
      ->required()
      ->expected(1)
      ->take_all()
      ->type_name("CSV");
  add_choice<Align>(
      *command, "--align", options->align,
      {{"first", Align::first}, {"fit", Align::fit}, {"none", Align::none}},
      "Alignment at the first common time, by least squares, or none; default: first");
  add_choice<Frame>(*command, "--frame", options->frame,
                    {{"map", Frame::map}, {"odom", Frame::odom}},
                    "Which pose: the map's or the jump-free odometry frame's; default: map");
  command
      ->add_option("--from", options->from,
                   "Judge only what is not before this time [s]; +T: after the reference's first "
                   "row")
      ->type_name("T|+T");
  command->add_option("--to", options->to, "... and not after this one")->type_name("T|+T");
  auto* lever_arm =
      command
          ->add_option("--lever-arm", options->lever_arm,
                       "Where the reference's point sits in the body frame [m, m, rad]")
          ->delimiter(',')
          ->expected(3)
          ->type_name("X,Y,YAW");
  command
      ->add_flag("--fit-lever-arm", options->fit_lever_arm,
                 "Fit one such lever arm to all pose files")
      ->excludes(lever_arm);
  command->add_flag("--json", options->json, "One JSON object, SI units");
  auto* picture = command
                      ->add_option("--picture", options->picture,
                                   "Draw the trajectories into a file, .svg or .png")
                      ->type_name("FILE");
  command->add_option("--title", options->title, "Title of the picture")
      ->type_name("TEXT")
      ->needs(picture);
  command->add_option("--camera", options->camera, "Camera log to draw as dots")
      ->type_name("CSV")
      ->needs(picture);
  command->footer(
      "Examples:\n"
      "  odom evaluate --reference truth.csv --pose pose.csv\n"
      "  odom evaluate --reference truth.csv --pose kinematic.csv --pose paper.csv --json\n"
      "  odom evaluate --reference truth.csv --pose pose.csv --align fit --picture lap.svg\n"
      "  odom evaluate --reference mocap.csv --pose pose.csv --fit-lever-arm\n"
      "  odom evaluate --reference truth.csv --pose pose.csv --from +15 --to +25 --frame odom\n"
      "Only times that both cover count; the reference is interpolated, never extrapolated.\n"
      "With several pose files the others are compared with the first.");
  command->callback([options] { run_evaluate(*options); });
}

}  // namespace odomd::tools
