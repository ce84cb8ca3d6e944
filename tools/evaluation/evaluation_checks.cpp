#include "tools/evaluation/evaluation_checks.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/text.hpp"
#include "tools/diagnostics/coverage_check.hpp"
#include "tools/diagnostics/heading_check.hpp"
#include "tools/diagnostics/unit_check.hpp"

namespace odomd::tools {

using diagnostics::Diagnostic;
using diagnostics::found;
using diagnostics::kind;

namespace {

bool is_in(const diagnostics::Diagnostics& some, const Diagnostic& one) {
  return std::ranges::any_of(some, [&one](const Diagnostic& other) {
    return other.kind == one.kind && text_of(other) == text_of(one);
  });
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

std::vector<Units> check_units(EvaluatedDrive& drive) {
  const auto are_unlike = [&drive](const Trajectory& poses, const Trajectory& other,
                                   const std::string& whose) {
    const diagnostics::Diagnostics units = check_units_of(poses, other, whose);
    append(drive.warnings, units);
    return !units.empty();
  };
  std::vector<Units> units(drive.estimates.size(), Units::alike);
  for (const Trajectory& estimate : drive.estimates) {
    if (!are_unlike(*drive.reference, estimate, "the estimate")) continue;
    std::ranges::fill(units, Units::unlike);
    return units;
  }
  append(drive.warnings, check_headings(*drive.reference));
  if (!drive.replays.empty()) return units;
  for (std::size_t i = 0; i < units.size(); ++i) {
    const Trajectory& estimate = drive.estimates[i];  // of whatever program
    if (are_unlike(estimate, *drive.reference, "the reference"))
      units[i] = Units::unlike;
    else
      append(drive.warnings, check_headings(estimate));
  }
  return units;
}

void check_coverage(EvaluatedDrive& drive, const Trajectory& judged,
                    const std::vector<Units>& units) {
  const Evaluation& first = drive.report.evaluations.front();
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    const Evaluation& e = drive.report.evaluations[i];
    const auto& points = drive.estimates[i].points;
    const auto report = [&](const diagnostics::Kind& kind, const std::string& seen) {
      drive.warnings.push_back(found(kind, e.name, seen));
    };
    const auto seconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-9; };
    const double whole_s = seconds(points.back().t_ns - points.front().t_ns);
    // A camera's reference has gaps, which are left out.
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
    if (e.reference_jumps > 0 && units[i] == Units::alike)
      report(kind("reference_jumps"), "the reference jumps " + std::to_string(e.reference_jumps) +
                                          " times faster than any car (100 m/s)");
    // An estimate from another program may move while the car stands.
    if (e.reference_stuck_ns > 0 && !drive.begins_elsewhere && units[i] == Units::alike)
      report(kind("reference_stuck"), "the reference stays at one place for " +
                                          fixed(seconds(e.reference_stuck_ns), 1) +
                                          " s while the estimate moves on");
    if (e.first_ns != first.first_ns || e.last_ns != first.last_ns)
      report(kind("other_time"), "its common time differs from that of " + first.name);
  }
}

}  // namespace odomd::tools
