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
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// Adds the replays' warnings about sensors. A warning of every model is added once, for the drive.
void check_sensors(EvaluatedDrive& drive);

/// Checks whether poses use the same units as another trajectory, named `whose` in messages.
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

/// Compares the times of a reference with those of estimates from pose files, without their log.
/// Nothing if the times agree.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_times(
    const Trajectory& reference, std::span<const Trajectory> estimates, Align align);

/// Compares the times of a drive's reference, given for the centre of gravity, with those of
/// motion() without the camera, which is on the log's clock. Replays the drive.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_times(const Trajectory& reference,
                                                                 const Drive& drive, Align align);

/// Warnings from the replay, and about an initial pose from another drive. With a reference, also
/// about its units, its headings and its times, and if it belongs to another drive. Throws like
/// replay_drive().
[[nodiscard]] diagnostics::Diagnostics check_drive(const Drive& drive);

// Detects a reference with wrong times. Without this check, an offset of tens of milliseconds looks
// like a bad filter whose sigmas are far too small.

struct TimeOffset {
  double late_s = 0.0;  ///< offset of the reference's times; negative: early
  double before = 0.0;  ///< rms error with the times as they are [m]
  double after = 0.0;   ///< rms error without the offset [m]
};

/// Finds the offset from positions and headings of the whole drive, if the estimate does not drift.
/// Nothing if errors have other causes, or the offset is below 20 ms or above 0.23 s.
[[nodiscard]] std::optional<TimeOffset> offset_by_positions(const Trajectory& reference,
                                                            const Trajectory& estimate,
                                                            Align align);

/// Finds the offset from displacement and yaw change over every second; the estimate may drift.
/// `before` and `after` are errors over a second. Some models turn with the steering, before the
/// car does; this does not count as an offset.
[[nodiscard]] std::optional<TimeOffset> offset_by_motion(const Trajectory& reference,
                                                         const Trajectory& estimate);

}  // namespace odomd::tools
