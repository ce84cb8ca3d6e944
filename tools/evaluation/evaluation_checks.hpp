// Plausibility checks of an evaluated drive: its reference, its estimates, and whether they belong
// together. Each finding becomes a warning of the drive.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/evaluation/evaluated_drive.hpp"

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

}  // namespace odomd::tools
