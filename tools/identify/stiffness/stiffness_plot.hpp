// The measured tyres as a picture: side force over slip angle of both axles, the circles as points,
// the slope at zero slip with its uncertainty, the fitted curve, and the linear range.
#pragma once

#include <vector>

#include "tools/chart/drawing.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"

namespace odomd::tools {

/// Front axle, rear axle.
[[nodiscard]] std::vector<chart::Drawing> draw_stiffness(const CorneringStiffness& found);

}  // namespace odomd::tools
