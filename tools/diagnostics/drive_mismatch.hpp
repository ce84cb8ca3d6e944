// Detects an estimate compared with the reference of another drive. Both clocks start alike, so
// every figure would look like that of a bad filter.
#pragma once

#include <optional>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

/// Whether the two turn so differently from second to second that they cannot be of one drive, or
/// look exchanged (sigmas in the reference alone). Nothing otherwise, and if the reference hardly
/// turns.
[[nodiscard]] std::optional<diagnostics::Diagnostic> drive_mismatch(const Trajectory& reference,
                                                                    const Trajectory& estimate);

}  // namespace odomd::tools
