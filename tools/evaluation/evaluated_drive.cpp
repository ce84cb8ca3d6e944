#include "tools/evaluation/evaluated_drive.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/chart/picture.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/text.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/evaluation/evaluation.hpp"
#include "tools/evaluation/evaluation_checks.hpp"
#include "tools/math/se2.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

using diagnostics::Diagnostic;

// "1760000015.5" is a time in the files, "+15.5" is seconds after their first row.
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

// No drive starts this long before its reference: the "+" is missing.
constexpr std::int64_t longest_before_ns = 86'400LL * 1'000'000'000;

/// The evaluated part, in times of the files.
struct Part {
  std::int64_t from_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t to_ns = std::numeric_limits<std::int64_t>::max();
};

Part part_of(const Judging& judging, std::int64_t first_ns) {
  const auto from = time_of("--from", judging.from, first_ns);
  const auto to = time_of("--to", judging.to, first_ns);
  if (from && first_ns - *from > longest_before_ns)
    throw std::invalid_argument("--from: " + tools::quoted(judging.from) +
                                " lies more than a day before the reference's first row; +" +
                                judging.from + " counts from there");
  const Part whole;
  return {from.value_or(whole.from_ns), to.value_or(whole.to_ns)};
}

bool is_steered(const EvaluatedDrive& drive) {
  return !drive.config || is_mapped(*drive.config, estimator::Source::steering);
}

std::size_t baseline_of(const EvaluatedDrive& drive, const std::string& name) {
  const std::vector<std::string> names = names_of(drive);
  // Without a steering signal the kinematic models drive straight.
  const char* const usual = is_steered(drive) ? "kinematic" : "inertial";
  const auto found = std::ranges::find(names, name.empty() ? usual : name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  if (name.empty()) return is_steered(drive) ? 0 : names.size() - 1;
  throw std::invalid_argument(fmt::format("--baseline: no estimate {}; available: {}",
                                          tools::quoted(name), fmt::join(names, ", ")));
}

// Evaluates the estimates as closed loops.
void judge_by_start(EvaluatedDrive& drive, const Judging& judging) {
  for (const Trajectory& estimate : drive.estimates) {
    if (drive.replays.empty()) append(drive.warnings, check_headings(estimate));
    drive.report.evaluations.push_back(evaluate_closed_loop(estimate));
  }
  if (judging.against == Against::closed_loop)
    append(drive.warnings, check_that_it_closes(drive.name, drive.report.evaluations));
  else if (!drive.loop_is_assumed)
    for (Evaluation& e : drive.report.evaluations) e = without_errors(e);
}

// Moves the reference to the centre of gravity. For `read`, see judge().
void remove_lever_arm(EvaluatedDrive& drive, const Judging& judging, const Drive* read) {
  EvaluationReport& report = drive.report;
  if (drive.reference->is_camera && (judging.lever_arm || judging.fit_lever_arm))
    throw std::invalid_argument(drive.name +
                                ": --lever-arm and --fit-lever-arm apply to truth.csv; without it "
                                "the reference is camera.csv with [camera] lever_arm");
  if (judging.lever_arm) {
    report.lever_arm = judging.lever_arm;
  } else if (judging.fit_lever_arm) {
    const diagnostics::Diagnostics units =
        check_units_of(*drive.reference, drive.estimates.front(), "the estimate");
    if (!units.empty()) throw std::invalid_argument(text_of(units.front()));
    const LeverArmFit fit = fit_lever_arm(*drive.reference, drive.estimates);
    report.lever_arm = fit.lever_arm;
    report.fitted_windows = fit.windows;
  } else if (read != nullptr && !drive.reference->is_camera) {
    const estimator::Pose2 arm = reference_arm(read->config);
    if (arm.x != 0.0 || arm.y != 0.0 || arm.yaw != 0.0) report.lever_arm = arm;
  }
  if (report.lever_arm) drive.reference = at_centre_of_gravity(*drive.reference, *report.lever_arm);
}

// Completes the evaluation once the estimates and the reference (as in its file) are set. `read` is
// the replayed drive; null for pose files.
void judge(EvaluatedDrive& drive, const Judging& judging, const Drive* read) {
  EvaluationReport& report = drive.report;
  drive.is_part = !judging.from.empty() || !judging.to.empty();
  report.frame = judging.frame;
  const bool has_cameras = read != nullptr && !read->cameras.empty();
  report.align = judging.align.value_or(usual_align(has_cameras, judging.frame));
  const Trajectory& timed = drive.reference ? *drive.reference : drive.estimates.front();
  const Part part = part_of(judging, timed.points.front().t_ns);
  for (Trajectory& estimate : drive.estimates)
    if (drive.is_part) estimate = cut_to(std::move(estimate), part.from_ns, part.to_ns);
  report.baseline = baseline_of(drive, judging.baseline);
  if (!drive.reference) return judge_by_start(drive, judging);
  report.reference = drive.reference->name;
  remove_lever_arm(drive, judging, read);
  const std::vector<bool> has_same_units = check_units(drive);
  bool is_of_the_drive = false;
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    const Trajectory& estimate = drive.estimates[i];
    report.evaluations.push_back(evaluate(*drive.reference, estimate, report.align));
    // A model that has stopped no longer turns, and its fault is reported already.
    if (!drive.replays.empty() && drive.replays[i].summary.fault_ns) continue;
    if (!has_same_units[i]) continue;
    const std::optional<Diagnostic> mismatch = drive_mismatch(*drive.reference, estimate);
    is_of_the_drive = is_of_the_drive || !mismatch;
    append(drive.warnings, mismatch);
  }
  // Only the evaluated part is checked.
  Trajectory judged = *drive.reference;
  std::erase_if(judged.points, [&part](const TrajectoryPoint& point) {
    return point.t_ns < part.from_ns || point.t_ns > part.to_ns;
  });
  if (judged.points.size() < 2) judged = *drive.reference;
  if (is_of_the_drive)
    append(drive.warnings, read != nullptr ? check_times(judged, *read, report.align)
                                           : check_times(judged, drive.estimates, report.align));
  check_coverage(drive, judged, has_same_units);
}

}  // namespace

bool camera_came_in(const EvaluatedDrive& drive) {
  return !drive.replays.empty() && drive.replays.front().summary.cameras > 0;
}

std::vector<std::string> names_of(const EvaluatedDrive& drive) {
  std::vector<std::string> files;
  for (const Trajectory& estimate : drive.estimates) files.push_back(estimate.name);
  return short_names(files);
}

std::vector<std::string> colours_of(const EvaluatedDrive& drive) {
  const std::vector<std::string> names = names_of(drive);
  const auto is_model = [](const std::string& name) {
    return std::ranges::find(estimator::model_names, name) != estimator::model_names.end();
  };
  const bool are_models = std::ranges::all_of(names, is_model);
  std::vector<std::string> colours;
  for (const std::string& name : names)
    colours.push_back(chart::colour_of(
        are_models ? static_cast<std::size_t>(std::ranges::find(estimator::model_names, name) -
                                              estimator::model_names.begin())
                   : colours.size()));
  return colours;
}

EvaluatedDrive evaluate_files(const std::string& reference, const std::vector<std::string>& poses,
                              const Judging& judging) {
  EvaluatedDrive drive;
  if (!reference.empty()) {
    drive.reference = read_trajectory(reference);
    append(drive.warnings, drive.reference->warnings);
  }
  for (const std::string& file : poses) {
    drive.estimates.push_back(read_trajectory(file, judging.frame));
    append(drive.warnings, drive.estimates.back().warnings);
  }
  drive.name = std::filesystem::path{reference.empty() ? poses.front() : reference}.stem().string();
  if (!judging.beat.empty()) drive.beat = read_beat_log(judging.beat);
  judge(drive, judging, nullptr);
  return drive;
}

std::vector<estimator::Model> usual_models(const daemon::Config& config) {
  using estimator::Model;
  if (!is_mapped(config, estimator::Source::yaw_rate))
    return {Model::kinematic, Model::paper, Model::full};
  return {Model::kinematic, Model::paper, Model::inertial, Model::full};
}

EvaluatedDrive evaluate_folder(const DriveFiles& files, const std::vector<estimator::Model>& models,
                               const Judging& judging) {
  Drive read = read_drive(files);
  EvaluatedDrive drive;
  drive.name = read.name;
  drive.cameras = read.cameras.empty() ? read.cameras_left_out : read.cameras;
  drive.config = read.config;
  append(drive.warnings, read.config.warnings);
  append(drive.warnings, read.warnings);
  if (judging.against != Against::closed_loop) {
    find_reference(read);
    drive.reference = std::move(read.reference);
    drive.loop_is_assumed = read.closed_loop;
  }
  const std::filesystem::path beat = judging.beat.empty() ? read.folder / "beat.csv" : judging.beat;
  if (!judging.beat.empty() || std::filesystem::exists(beat)) drive.beat = read_beat_log(beat);

  for (const estimator::Model model : models.empty() ? usual_models(read.config) : models) {
    daemon::Config config = read.config;
    config.model = model;
    ReplayedDrive replayed = replay_drive(read, config, judging.frame, judging.judgements);
    drive.estimates.push_back(std::exchange(replayed.poses, {}));
    drive.estimates.back().name = daemon::name_of(model);
    drive.replays.push_back(std::move(replayed));
  }
  const ReplaySummary& replayed = drive.replays.front().summary;
  const auto elsewhere = check_initial_pose(read.config, read.cameras, replayed.first_tick_ns);
  drive.begins_elsewhere = elsewhere.has_value();
  if (replayed.camera_units.empty()) append(drive.warnings, elsewhere);
  check_sensors(drive);
  judge(drive, judging, &read);
  for (std::size_t i = 0; i < drive.replays.size(); ++i)
    drive.report.evaluations[i].nis_factor = nis_factor(drive.replays[i].summary);
  return drive;
}

}  // namespace odomd::tools
