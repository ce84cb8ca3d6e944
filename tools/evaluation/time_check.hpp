// Detects wrong times of the reference, the camera, or both, and says what to do.
#pragma once

#include <optional>
#include <span>

#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/evaluation/time_offset.hpp"
#include "tools/replay/drive.hpp"

namespace odomd::tools {

/// The times of a reference compared with estimates that were read from files, whose log is not
/// known. Nothing if they agree.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_times(
    const Trajectory& reference, std::span<const Trajectory> estimates, Align align);

/// The same for a drive, compared with motion() without the camera, which is on the log's clock.
/// The reference is that of the centre of gravity. Needs a replay.
[[nodiscard]] std::optional<diagnostics::Diagnostic> check_times(const Trajectory& reference,
                                                                 const Drive& drive, Align align);

}  // namespace odomd::tools
