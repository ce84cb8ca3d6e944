#include "tools/evaluation/evaluation_checks.hpp"

#include <algorithm>

#include "tools/cli/text.hpp"
#include "tools/diagnostics/coverage_check.hpp"
#include "tools/diagnostics/heading_check.hpp"
#include "tools/diagnostics/unit_check.hpp"

namespace odomd::tools {

void check_sensors(EvaluatedDrive& drive) {
  for (const ReplayedDrive& replay : drive.replays) {
    for (const std::string& warning : replay.warnings) {
      const auto is_it = [&warning](const EvaluationWarning& one) { return one.text == warning; };
      const bool shared =
          std::ranges::all_of(drive.replays, [&warning](const ReplayedDrive& other) {
            return std::ranges::find(other.warnings, warning) != other.warnings.end();
          });
      if (shared && std::ranges::any_of(drive.warnings, is_it)) continue;
      const auto index = static_cast<std::size_t>(&replay - drive.replays.data());
      drive.warnings.push_back({shared ? "" : drive.estimates[index].name, warning});
    }
  }
}

void check_heading(EvaluatedDrive& drive, const Trajectory& trajectory) {
  const std::string warning = heading_warning(trajectory);
  if (!warning.empty()) drive.warnings.push_back({trajectory.name, warning});
}

std::string unit_warning_between(const Trajectory& poses, const Trajectory& other,
                                 const std::string& whose) {
  return unit_warning(poses.points, {.trajectory = other, .way_of = whose, .turn_of = whose});
}

std::vector<Units> check_units(EvaluatedDrive& drive) {
  const auto warn = [&drive](const Trajectory& poses, const Trajectory& other,
                             const std::string& whose) {
    const std::string text = unit_warning_between(poses, other, whose);
    if (!text.empty()) drive.warnings.push_back({poses.name, text});
    return !text.empty();
  };
  std::vector<Units> units(drive.estimates.size(), Units::alike);
  for (const Trajectory& estimate : drive.estimates) {
    if (!warn(*drive.reference, estimate, "the estimate")) continue;
    std::ranges::fill(units, Units::unlike);
    return units;
  }
  check_heading(drive, *drive.reference);
  if (!drive.replays.empty()) return units;
  for (std::size_t i = 0; i < units.size(); ++i) {
    const Trajectory& estimate = drive.estimates[i];  // of whatever program
    if (warn(estimate, *drive.reference, "the reference"))
      units[i] = Units::unlike;
    else
      check_heading(drive, estimate);
  }
  return units;
}

void check_coverage(EvaluatedDrive& drive, const Trajectory& judged,
                    const std::vector<Units>& units) {
  constexpr std::int64_t long_gap_ns = 200'000'000;
  constexpr double least_covered = 0.9;
  const Evaluation& first = drive.report.evaluations.front();
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    const Evaluation& e = drive.report.evaluations[i];
    const auto& points = drive.estimates[i].points;
    const auto seconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-9; };
    const double whole_s = seconds(points.back().t_ns - points.front().t_ns);
    const double covered_s = seconds(e.last_ns - e.first_ns);
    if (covered_s < least_covered * whole_s) {
      drive.warnings.push_back({e.name, "the reference covers " + fixed(covered_s, 1) + " s of " +
                                            fixed(whole_s, 1) + " s; the rest is not evaluated"});
    }
    const std::string warning = coverage_warning(judged, drive.estimates[i]);
    if (!warning.empty()) drive.warnings.push_back({e.name, warning});
    if (e.reference_gap_ns > long_gap_ns) {
      drive.warnings.push_back(
          {e.name, "the reference has a gap of " +
                       fixed(static_cast<double>(e.reference_gap_ns) * 1e-9, 2) +
                       " s, bridged by a straight line"});
    }
    if (e.reference_jumps > 0 && units[i] == Units::alike) {
      drive.warnings.push_back({e.name, "the reference jumps " + std::to_string(e.reference_jumps) +
                                            " times faster than any car (100 m/s); path length, "
                                            "maxima and 35 ms errors include these jumps"});
    }
    // An estimate from another program may move while the car stands.
    if (e.reference_stuck_ns > 0 && !drive.begins_elsewhere && units[i] == Units::alike) {
      drive.warnings.push_back(
          {e.name, "the reference stays at one place for " +
                       fixed(seconds(e.reference_stuck_ns), 1) +
                       " s while the estimate moves on: check whether its tracker lost the car, or "
                       "the wheels spin; --from and --to leave a part out"});
    }
    if (e.first_ns != first.first_ns || e.last_ns != first.last_ns) {
      drive.warnings.push_back({e.name, "its common time differs from that of " + first.name +
                                            "; compare their figures with care"});
    }
  }
}

}  // namespace odomd::tools
