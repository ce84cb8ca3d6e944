// Detects an estimate of only a part of the drive: a pose file that was cut off or has a gap.
#pragma once

#include <optional>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// Nothing if the estimate covers enough of the reference's path. Time at standstill does not
/// count.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_coverage(const Trajectory& reference,
                                                                    const Trajectory& estimate);

}  // namespace odomd::tools
