#include "tools/evaluation/evaluation_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/seconds.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/kinds.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/replay/replay_checks.hpp"

namespace odomd::tools {
namespace {

using diagnostics::Diagnostic;
using diagnostics::found;

bool is_in(const diagnostics::Diagnostics& some, const Diagnostic& one) {
  return std::ranges::any_of(some, [&one](const Diagnostic& other) {
    return other.kind == one.kind && text_of(other) == text_of(one);
  });
}

constexpr double same_clock = 0.015;  // s

std::optional<Diagnostic> report(const std::string& whose, const std::string& seen) {
  return found(kind("clocks_differ"), whose, seen);
}

// Keeps the offset that leaves the smallest error: a poor model has time errors of its own.
void keep_the_better(std::optional<TimeOffset>& best, const std::optional<TimeOffset>& other) {
  if (other && (!best || other->after < best->after)) best = other;
}

std::string look(double late_s) {
  return fmt::format("look {:.0f} ms {}", std::fabs(1e3 * late_s), late_s > 0.0 ? "late" : "early");
}

std::string by_how_much(const TimeOffset& offset, const char* error) {
  return fmt::format(" (the {} would be {:.3f} m, not {:.3f} m)", error, offset.after,
                     offset.before);
}

}  // namespace

void check_sensors(EvaluatedDrive& drive) {
  for (std::size_t i = 0; i < drive.replays.size(); ++i) {
    for (Diagnostic warning : drive.replays[i].warnings) {
      const bool shared = std::ranges::all_of(drive.replays, [&](const ReplayedDrive& other) {
        return is_in(other.warnings, warning);
      });
      if (shared && is_in(drive.warnings, warning)) continue;
      if (!shared)
        warning.subject =
            drive.estimates[i].name + (warning.subject.empty() ? "" : ": ") + warning.subject;
      drive.warnings.push_back(std::move(warning));
    }
  }
}

diagnostics::Diagnostics check_units_of(const Trajectory& poses, const Trajectory& other,
                                        const std::string& whose) {
  return check_units(poses.name, poses.points,
                     {.trajectory = other, .way_of = whose, .turn_of = whose});
}

std::vector<bool> check_units(EvaluatedDrive& drive) {
  const auto are_alike = [&drive](const Trajectory& poses, const Trajectory& other,
                                  const std::string& whose) {
    const diagnostics::Diagnostics units = check_units_of(poses, other, whose);
    append(drive.warnings, units);
    return units.empty();
  };
  for (const Trajectory& estimate : drive.estimates)
    if (!are_alike(*drive.reference, estimate, "the estimate"))
      return std::vector<bool>(drive.estimates.size(), false);
  append(drive.warnings, check_headings(*drive.reference));
  std::vector<bool> has_same_units;
  for (const Trajectory& estimate : drive.estimates) {  // may be another program's
    has_same_units.push_back(!drive.replays.empty() ||
                             are_alike(estimate, *drive.reference, "the reference"));
    if (drive.replays.empty() && has_same_units.back())
      append(drive.warnings, check_headings(estimate));
  }
  return has_same_units;
}

void check_coverage(EvaluatedDrive& drive, const Trajectory& judged,
                    const std::vector<bool>& has_same_units) {
  const Evaluation& first = drive.report.evaluations.front();
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    const Evaluation& e = drive.report.evaluations[i];
    const auto& points = drive.estimates[i].points;
    const auto report = [&](const diagnostics::Kind& kind, const std::string& seen) {
      drive.warnings.push_back(found(kind, e.name, seen));
    };
    const double whole_s = seconds(points.back().t_ns - points.front().t_ns);
    // A camera reference has gaps, in which nothing is compared.
    const double covered_s =
        drive.reference && drive.reference->is_camera
            ? whole_s * static_cast<double>(e.samples) / static_cast<double>(points.size())
            : seconds(e.last_ns - e.first_ns);
    constexpr const diagnostics::Kind& part = kind("reference_covers_part");
    if (covered_s < part.limits.least * whole_s)
      report(part,
             "the reference covers " + fixed(covered_s, 1) + " s of " + fixed(whole_s, 1) + " s");
    append(drive.warnings, check_coverage(judged, drive.estimates[i]));
    constexpr const diagnostics::Kind& gap = kind("reference_gap");
    if (!gap.limits.hold(seconds(e.reference_gap_ns)))
      report(gap, "the reference has a gap of " + fixed(seconds(e.reference_gap_ns), 2) + " s");
    if (e.reference_jumps > 0 && has_same_units[i])
      report(kind("reference_jumps"), "the reference jumps " + std::to_string(e.reference_jumps) +
                                          " times faster than any car (100 m/s)");
    // An estimate from another program may move while the car is stationary.
    if (e.reference_stuck_ns > 0 && !drive.begins_elsewhere && has_same_units[i])
      report(kind("reference_stuck"), "the reference stays at one place for " +
                                          fixed(seconds(e.reference_stuck_ns), 1) +
                                          " s while the estimate moves on");
    constexpr const diagnostics::Kind& other_time = kind("other_time");
    const double apart_s = seconds(std::abs(e.first_ns - first.first_ns)) +
                           seconds(std::abs(e.last_ns - first.last_ns));
    if (!other_time.limits.hold(apart_s / seconds(first.last_ns - first.first_ns)))
      report(other_time, fmt::format("its common time differs by {:.2f} s from that of {}", apart_s,
                                     first.name));
  }
}

std::optional<Diagnostic> check_times(const Trajectory& reference,
                                      std::span<const Trajectory> estimates, Align align) {
  std::optional<TimeOffset> found;
  for (const Trajectory& estimate : estimates)
    keep_the_better(found, offset_by_positions(reference, estimate, align));
  const char* error = "position rms";
  if (!found) {
    for (const Trajectory& estimate : estimates)
      keep_the_better(found, offset_by_motion(reference, estimate));
    error = "error over a second";
  }
  if (!found) return std::nullopt;
  return report(reference.name, "its times " + look(found->late_s) + " compared with the poses" +
                                    by_how_much(*found, error));
}

std::optional<Diagnostic> check_times(const Trajectory& reference, const Drive& drive,
                                      Align align) {
  const std::optional<Trajectory> odometry = motion(drive);
  if (!odometry) return std::nullopt;
  const std::optional<TimeOffset> of_reference = offset_by_motion(reference, *odometry);
  if (drive.cameras.empty() || reference.is_camera) {
    if (!of_reference) return std::nullopt;
    return report(reference.name, "its times " + look(of_reference->late_s) + " against the bus" +
                                      by_how_much(*of_reference, "error over a second"));
  }
  const auto& arm = drive.config.camera.lever_arm;
  const Trajectory camera = camera_trajectory(drive.cameras, {arm[0], arm[1], arm[2]});
  const std::optional<TimeOffset> of_camera = offset_by_motion(camera, *odometry);
  const std::optional<TimeOffset> between =
      offset_by_positions(reference, camera, align == Align::none ? Align::none : Align::fit);
  if (!between) {
    if (!of_reference || !of_camera ||
        std::fabs(of_reference->late_s - of_camera->late_s) > same_clock)
      return std::nullopt;
    return report(reference.name + ", camera.csv",
                  "their times " + look(of_reference->late_s) + " against the bus");
  }
  const std::string difference = by_how_much(*between, "rms between the two");
  // The bus shows whether reference or camera is off; the offset between the two is more precise.
  if (of_camera && !of_reference)
    return report("camera.csv",
                  "its times " + look(-between->late_s) + " against the bus" + difference);
  if (of_reference && !of_camera)
    return report(reference.name,
                  "its times " + look(between->late_s) + " against the bus" + difference);
  return report(
      reference.name + " and camera.csv",
      fmt::format("their times look {:.0f} ms apart, {} later{}", std::fabs(1e3 * between->late_s),
                  between->late_s > 0.0 ? "the reference's" : "the camera's", difference));
}

diagnostics::Diagnostics check_drive(const Drive& drive) {
  const daemon::Config& config = drive.config;
  const ReplayedDrive replayed = replay_drive(drive, config);
  diagnostics::Diagnostics warnings = replayed.warnings;
  if (replayed.summary.camera_units.empty())
    append(warnings, check_initial_pose(config, drive.cameras, replayed.summary.first_tick_ns));
  if (!drive.reference) return warnings;
  const Trajectory reference = reference_of(drive);
  if (const auto units = check_units_of(reference, replayed.poses, "the estimate");
      !units.empty()) {
    append(warnings, units);
    return warnings;
  }
  append(warnings, check_headings(reference));
  // A model that has stopped no longer turns, and has been reported already.
  std::optional<diagnostics::Diagnostic> mismatch;
  if (!replayed.summary.fault_ns) mismatch = drive_mismatch(reference, replayed.poses);
  if (mismatch) mismatch->subject = daemon::name_of(config.model);
  append(warnings,
         mismatch ? mismatch
                  : check_times(reference, drive, usual_align(!drive.cameras.empty(), Frame::map)));
  return warnings;
}

}  // namespace odomd::tools
