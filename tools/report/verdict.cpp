#include "tools/report/page.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "tools/cli/text.hpp"
#include "tools/math/median.hpp"
#include "tools/report/figures.hpp"

namespace odomd::tools::report {
namespace {

/// Grades a value: Grade::good up to `good`, Grade::look_at up to `look_at`, Grade::wrong beyond.
struct Thresholds {
  double good;
  double look_at;

  [[nodiscard]] Grade grade(double value) const {
    return value <= good ? Grade::good : value <= look_at ? Grade::look_at : Grade::wrong;
  }
};

// In the paper the filter ends within 1.25 cm per metre of the lap, the kinematic model within 7.2.
// Twice 1.25 is usual for a filter; beyond 7.2 a filter is no better than that model.
constexpr Thresholds drift{2.5, 7.2};  // cm/m

// A filter with a camera averages its poses: its rms error should be below the sigma of one pose.
// From three times that sigma on, it does not follow the camera.
constexpr Thresholds camera_error_ratio{1.0, 3.0};

// NEES 6 is twice the expected 3: sigmas are too small by 1.4, which 3-sigma limits tolerate. At 15
// they are too small by 2.2, and 18 % of an axis's errors exceed its 3 sigma.
constexpr Thresholds nees{6.0, 15.0};
constexpr double low_nees = 0.75;  // sigmas twice as large as the errors

// Limits of NIS / expected for a source: its noise is then wrong by a factor of two.
constexpr double min_nis = 0.25;
constexpr double max_nis = 4.0;

/// Limits of the heading's sigma, and of the share of the drive in which it may be larger.
constexpr double max_heading_sigma = 10.0, max_uncertain_share = 0.1;  // deg

/// Shorter drives may end near the reference by chance: their drift is not judged.
constexpr double min_path = 5.0;  // m

/// A camera as reference makes the position rms of simulated drives up to 28 % larger, most for the
/// best model (docs/evaluation.md). With truth, differences below 5 % are chance.
constexpr double min_improvement = 5.0, min_improvement_with_camera = 30.0;  // %

void judge_fault(const EvaluatedDrive& drive, std::size_t focus, DriveVerdict& verdict) {
  if (focus >= drive.replays.size()) return;
  const ReplaySummary& summary = drive.replays[focus].summary;
  if (!summary.fault_ns) return;
  verdict.add(
      Grade::wrong,
      fmt::format("It stopped with a fault {} s after the start; its figures are those of the "
                  "pose at which it stopped.",
                  fixed(static_cast<double>(*summary.fault_ns - summary.first_tick_ns) * 1e-9, 1)));
}

void judge_warnings(const EvaluatedDrive& drive, DriveVerdict& verdict) {
  if (drive.warnings.empty()) return;
  std::string codes;
  for (const diagnostics::Diagnostic& warning : drive.warnings) {
    const std::string code{warning.kind->code};
    if (codes.find(code) == std::string::npos) codes += (codes.empty() ? "" : ", ") + code;
  }
  verdict.add(Grade::look_at,
              fmt::format("{} ({}), listed with the drive: fix these first, as they "
                          "may explain the rest.",
                          counted(drive.warnings.size(), "warning"), codes));
}

// Start of the sentence about the drift: which position is judged.
std::string subject_of(const EvaluatedDrive& drive) {
  if (drive.replays.empty()) return "Its position is";
  if (camera_came_in(drive)) return "In the frame without jumps its position is";
  return "Without the camera its position is";
}

// Returns false if the drift cannot be judged.
bool judge_drift(const EvaluatedDrive& drive, const Evaluation& e, DriveVerdict& verdict) {
  if (!e.end_cm_per_m || e.path_length < min_path) return false;
  // The end may be right by chance: the rms counts, too.
  const double off =
      std::max(has_reference(e.against) ? e.position.rms : 0.0, e.end_error) / e.path_length;
  const std::string rms =
      has_reference(e.against) ? fmt::format("{} m off rms and ", fixed(e.position.rms, 3)) : "";
  verdict.add(drift.grade(100.0 * off),
              fmt::format("{} {}{} m off at the end of {} m: {} % of the distance. "
                          "Up to {} % is good; above {} % it is no better than the paper's car "
                          "without a filter.",
                          subject_of(drive), rms, fixed(e.end_error, 3), fixed(e.path_length, 0),
                          fixed(100.0 * off, 2), fixed(drift.good, 1), fixed(drift.look_at, 1)));
  if (drive.loop_is_assumed)
    verdict.add(Grade::look_at,
                "It is assumed that the drive ends where it began, because the poses nearly do: "
                "confirm it with --closed-loop.");
  return true;
}

bool judge_with_camera(const EvaluatedDrive& drive, const Evaluation& e, DriveVerdict& verdict) {
  if (!has_reference(e.against) || drive.cameras.empty()) return false;
  std::vector<double> sigmas;
  for (const estimator::CameraPose& pose : drive.cameras)
    sigmas.push_back(std::hypot(pose.sigma_x, pose.sigma_y));
  const double pose = median_of(std::move(sigmas));
  const Grade grade = camera_error_ratio.grade(e.position.rms / pose);
  verdict.add(grade,
              fmt::format("With the camera its position is off by {} mm rms, {} than one camera "
                          "pose, whose stated sigma of x and y together is {} mm.",
                          fixed(1e3 * e.position.rms, 1),
                          grade == Grade::good      ? "less"
                          : grade == Grade::look_at ? "more"
                                                    : "far more",
                          fixed(1e3 * pose, 1)));
  return true;
}

void judge_baseline(const EvaluatedDrive& drive, std::size_t focus, DriveVerdict& verdict) {
  const Evaluation& e = drive.report.evaluations[focus];
  const Evaluation& baseline = drive.report.evaluations[drive.report.baseline];
  if (&e == &baseline) return;
  const bool everywhere = has_reference(e.against);
  const std::optional<double> better = everywhere
                                           ? improvement(e.position.rms, baseline.position.rms)
                                           : improvement(e.end_error, baseline.end_error);
  if (!better || e.against == Against::nothing) return;
  const std::string than = names_of(drive)[drive.report.baseline];
  const char* const of = everywhere ? "position rms" : "error at the end";
  const double clear = e.against == Against::camera ? min_improvement_with_camera : min_improvement;
  if (*better >= clear)
    verdict.add(Grade::good, fmt::format("Its {} is {} % smaller than that of {}.", of,
                                         fixed(*better, 0), than));
  else if (*better < -clear)
    verdict.add(
        Grade::look_at,
        fmt::format("Its {} is {} % larger than that of {}{}.", of, fixed(-*better, 0), than,
                    drive.replays.empty()
                        ? ""
                        : ": check what " + than + " does not use (gyro, accelerometers, tyres)"));
  else
    verdict.add(Grade::good, fmt::format("Its {} is about the same as that of {}.", of, than));
}

void judge_nees(const Evaluation& e, DriveVerdict& verdict) {
  if (!e.consistency) return;
  const double mean = e.consistency->nees;
  const std::string figure = "the mean NEES is " + fixed(mean, 1) + " (3 is expected)";
  if (mean < low_nees)
    verdict.add(Grade::look_at, "Its sigmas are too large: " + figure + ".");
  else if (nees.grade(mean) == Grade::good)
    verdict.add(Grade::good, "Its sigmas fit its errors: " + figure + ".");
  else
    verdict.add(
        nees.grade(mean),
        fmt::format("Its sigmas are too small: {}; its errors are {} times as large as they "
                    "predict.",
                    figure, fixed(std::sqrt(mean / 3.0), 1)));
}

void judge_heading(const EvaluatedDrive& drive, std::size_t focus, DriveVerdict& verdict) {
  const Trajectory& poses = drive.estimates[focus];
  if (!poses.has_covariance || poses.points.empty()) return;
  const auto uncertain = std::ranges::count_if(poses.points, [](const TrajectoryPoint& point) {
    return std::sqrt(std::max(point.covariance[5], 0.0)) * degrees > max_heading_sigma;
  });
  const double share = static_cast<double>(uncertain) / static_cast<double>(poses.points.size());
  if (share > max_uncertain_share)
    verdict.add(Grade::look_at,
                fmt::format("Its heading is uncertain: its sigma is above {} degrees for {} % of "
                            "the time.",
                            fixed(max_heading_sigma, 0), fixed(100.0 * share, 0)));
}

void judge_innovations(const EvaluatedDrive& drive, std::size_t focus, DriveVerdict& verdict) {
  if (focus >= drive.replays.size() || !drive.report.evaluations[focus].nis_factor) return;
  std::string off;
  const auto& all = drive.replays[focus].summary.innovations;
  for (std::size_t source = 0; source < all.size(); ++source) {
    if (all[source].count == 0) continue;
    const double ratio = all[source].nis_per_degree();
    if (ratio >= min_nis && ratio <= max_nis) continue;
    off += fmt::format("{}{} ({})", off.empty() ? "" : ", ", estimator::source_names[source],
                       fixed(ratio, 2));
  }
  if (off.empty())
    verdict.add(
        Grade::good,
        fmt::format("Every sensor agrees with it as closely as its noise setting predicts: NIS / "
                    "expected is between {} and {} for each.",
                    fixed(min_nis, 2), fixed(max_nis, 0)));
  else
    verdict.add(
        Grade::look_at,
        fmt::format("Sensors whose noise setting does not fit, with NIS / expected outside {} "
                    "to {}: {}. Above, the noise is set too small or the model is wrong; "
                    "below, the noise is set too large.",
                    fixed(min_nis, 2), fixed(max_nis, 0), off));
}

}  // namespace

std::string in_words(Grade grade) {
  static constexpr std::array words{"good", "look at", "wrong"};
  return words.at(static_cast<std::size_t>(grade));
}

DriveVerdict verdict_of(const EvaluatedDrive& drive) {
  const std::size_t focus = focus_of(drive);
  const Evaluation& e = drive.report.evaluations[focus];
  DriveVerdict verdict;
  judge_fault(drive, focus, verdict);
  judge_warnings(drive, verdict);
  const bool position_is_judged = camera_came_in(drive) && drive.report.frame == Frame::map
                                      ? judge_with_camera(drive, e, verdict)
                                      : judge_drift(drive, e, verdict);
  judge_baseline(drive, focus, verdict);
  judge_nees(e, verdict);
  judge_heading(drive, focus, verdict);
  judge_innovations(drive, focus, verdict);
  if (!position_is_judged)
    verdict.add(Grade::look_at,
                "It is unknown whether the position is right: there is nothing to compare it "
                "with, or the car drove less than 5 m.");
  verdict.subject = names_of(drive)[focus] + (camera_came_in(drive)    ? " with the camera"
                                              : !drive.replays.empty() ? " by dead reckoning"
                                                                       : "");
  verdict.basis = basis_in_words(drive.report);
  std::ranges::stable_sort(verdict.reasons, std::ranges::greater{}, &Reason::grade);
  return verdict;
}

std::string as_text(const DriveVerdict& verdict) {
  std::string text = fmt::format("{}: {}\n", in_words(verdict.grade), verdict.subject);
  for (const Reason& reason : verdict.reasons)
    text += fmt::format("  {}: {}\n", in_words(reason.grade), reason.sentence);
  return text;
}

nlohmann::ordered_json as_json(const DriveVerdict& verdict) {
  nlohmann::ordered_json reasons = nlohmann::ordered_json::array();
  for (const Reason& reason : verdict.reasons)
    reasons.push_back({{"grade", in_words(reason.grade)}, {"sentence", reason.sentence}});
  return {{"grade", in_words(verdict.grade)},
          {"subject", verdict.subject},
          {"basis", verdict.basis},
          {"reasons", std::move(reasons)}};
}

}  // namespace odomd::tools::report
