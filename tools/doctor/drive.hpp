// A drive replayed with its configuration: signs, sides, axles, axes, units and times of its
// sensors, its camera and its reference.
#pragma once

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::doctor {

/// What is wrong with a drive, causes without their consequences: its configuration, its traffic
/// (examine_traffic() in bus.hpp), and what the replay shows. Throws std::invalid_argument for a
/// folder that cannot be read.
[[nodiscard]] diagnostics::Diagnostics examine_drive(const DriveFiles& files);
/// The same for a drive that has been read or listened to.
[[nodiscard]] diagnostics::Diagnostics examine_drive(const Drive& drive);

}  // namespace odomd::tools::doctor
