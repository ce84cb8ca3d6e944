// The picture of an evaluation: what is drawn and what the legend says.
#pragma once

#include <span>
#include <string>

#include "estimator/measurement.hpp"
#include "tools/chart/map.hpp"
#include "tools/evaluation.hpp"
#include "tools/trajectory.hpp"

namespace odomd::tools {

/// Reference and aligned estimates within their common time, camera poses as dots; cm/m and heading
/// in the legend. `evaluations` are those of `estimates`, in the same order.
[[nodiscard]] chart::Map evaluation_map(const Trajectory& reference,
                                        std::span<const Trajectory> estimates,
                                        std::span<const Evaluation> evaluations,
                                        std::span<const estimator::CameraPose> camera,
                                        const std::string& title);

}  // namespace odomd::tools
