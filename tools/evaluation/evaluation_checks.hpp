// Diagnostics of an evaluated drive, from its errors and time offsets.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/evaluation/drive_evaluation.hpp"
#include "tools/evaluation/evaluated_drive.hpp"
#include "tools/evaluation/time_offset.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// Adds the replays' warnings about sensors. A warning of every model is added once, for the drive.
void check_sensors(EvaluatedDrive& drive);

/// Checks whether the units of poses are those of another trajectory, which messages call `whose`.
[[nodiscard]] diagnostics::Diagnostics check_units_of(const Trajectory& poses,
                                                      const Trajectory& other,
                                                      const std::string& whose);

/// For each estimate, whether it has the units of the reference. If not, most other warnings about
/// the two are left out, as they follow from this. Also checks the headings of the reference and of
/// estimates in the same units.
[[nodiscard]] std::vector<bool> check_units(EvaluatedDrive& drive);

/// Warns of parts of the reference that are not evaluated: jumps, gaps and standstills. `judged`:
/// the requested part of the reference. Needs the evaluations.
void check_coverage(EvaluatedDrive& drive, const Trajectory& judged,
                    const std::vector<bool>& has_same_units);

/// Compares the times of a reference with those of estimates from files, whose log is not known.
/// Nothing if they agree.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_times(
    const Trajectory& reference, std::span<const Trajectory> estimates, Align align);

/// Compares the times of a drive's reference with those of motion() without the camera, which is on
/// the log's clock. The reference is that of the centre of gravity. Replays the drive.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_times(const Trajectory& reference,
                                                                 const Drive& drive, Align align);

/// Warnings of the replay, and of an initial pose of another drive; with a reference, of its units
/// and headings, of a reference of another drive, and of wrong times. Throws like replay_drive().
[[nodiscard]] diagnostics::Diagnostics check_drive(const Drive& drive);

}  // namespace odomd::tools
