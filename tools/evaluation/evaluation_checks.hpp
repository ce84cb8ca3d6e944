// Diagnostics of an evaluated drive: what its errors and time offsets say about its configuration.
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

/// The replays' warnings about sensors. A warning that every model gives becomes one of the drive.
void check_sensors(EvaluatedDrive& drive);

/// Poses in other units than those of another trajectory, which messages call `whose`.
[[nodiscard]] diagnostics::Diagnostics check_units_of(const Trajectory& poses,
                                                      const Trajectory& other,
                                                      const std::string& whose);

/// The units of reference and estimate. If they differ, most other warnings about the two are left
/// out, as they follow from this.
enum class Units : std::uint8_t { alike, unlike };

/// The units of each estimate. Also checks the headings of the reference and of estimates in the
/// same units.
[[nodiscard]] std::vector<Units> check_units(EvaluatedDrive& drive);

/// Warns of parts of the reference (`judged`: the part that was asked for) that are not evaluated:
/// jumps, gaps and standstills. Needs the evaluations.
void check_coverage(EvaluatedDrive& drive, const Trajectory& judged,
                    const std::vector<Units>& units);

/// The times of a reference compared with estimates that were read from files, whose log is not
/// known. Nothing if they agree.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_times(
    const Trajectory& reference, std::span<const Trajectory> estimates, Align align);

/// The same for a drive, compared with motion() without the camera, which is on the log's clock.
/// The reference is that of the centre of gravity. Needs a replay.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_times(const Trajectory& reference,
                                                                 const Drive& drive, Align align);

/// Those of the replay, and an initial pose of another drive; with a reference, its units and
/// headings, a reference of another drive, and wrong times of the two. Throws as replay_drive().
[[nodiscard]] diagnostics::Diagnostics check_drive(const Drive& drive);

}  // namespace odomd::tools
