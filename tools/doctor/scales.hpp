// The sensor whose scale is wrong: of all comparisons between sensors that a drive allows, those
// that a factor on one of them, on an axle's wheels or on all wheels explains.
#pragma once

#include <optional>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/common/signal_log.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools::doctor {

/// Compares the wheels' distances, the turns by gyro, wheels and steering, and the accelerations,
/// with the camera's poses, else the reference's, else with each other. Nothing if no factor is
/// certain, or if the drive does not tell one sensor's from another's.
[[nodiscard]] std::optional<diagnostics::Diagnostic> find_wrong_scale(const Drive& drive,
                                                                      const SignalLog& log);

}  // namespace odomd::tools::doctor
