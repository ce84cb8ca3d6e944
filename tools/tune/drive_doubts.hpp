// Drives that are not worth tuning on as they are: what odom replay and odom evaluate would say.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/evaluation/drive_evaluation.hpp"

namespace odomd::tools {

/// One line each: what the replay of the drive as it is configured doubts, a reference or a camera
/// of another drive, and times that are off. None of a drive that cannot be judged at all, which
/// the search says.
[[nodiscard]] std::vector<std::string> drive_doubts(const Drive& drive,
                                                    std::optional<estimator::Model> model,
                                                    const Measure& measure);

}  // namespace odomd::tools
