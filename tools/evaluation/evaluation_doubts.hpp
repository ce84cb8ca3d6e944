// What there is to doubt in a drive that is judged: its reference, its estimates, and whether they
// belong together. Each is a warning of the drive.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools {

/// What the replays have to say of the sensors; what every model says is said once, of the drive.
void doubt_sensors(EvaluatedDrive& drive);

/// Headings that do not go with the way.
void doubt_heading(EvaluatedDrive& drive, const Trajectory& trajectory);

/// What to say of poses in other units than those of another trajectory, which messages call
/// `whose`; empty where there is nothing to say.
[[nodiscard]] std::string unit_doubt_beside(const Trajectory& poses, const Trajectory& other,
                                            const std::string& whose);

/// Those of reference and estimate. Where they are unlike, little else is said of the two, as it
/// comes of this.
enum class Units : std::uint8_t { alike, unlike };

/// Of each estimate; doubts the headings of those that are alike, and of the reference.
[[nodiscard]] std::vector<Units> doubt_units(EvaluatedDrive& drive);

/// Parts of the reference (`judged`: as far as it is asked for) that are not judged; its jumps,
/// gaps and standstills. Needs the evaluations.
void doubt_coverage(EvaluatedDrive& drive, const Trajectory& judged,
                    const std::vector<Units>& units);

}  // namespace odomd::tools
