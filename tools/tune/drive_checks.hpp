// Finds drives that should not be tuned on as they are: what odom replay and odom evaluate would
// report.
#pragma once

#include <optional>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/evaluation/drive_evaluation.hpp"

namespace odomd::tools {

/// Those of the replay with the present configuration, a reference or a camera of
/// another drive, and wrong times. Empty for a drive that cannot be evaluated at all: the search
/// reports that.
[[nodiscard]] diagnostics::Diagnostics check_drive(const Drive& drive,
                                                   std::optional<estimator::Model> model,
                                                   const Measure& measure);

}  // namespace odomd::tools
