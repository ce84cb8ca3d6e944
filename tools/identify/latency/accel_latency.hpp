// How late accelerations are, over the speed and the turn. Tyres and slopes are in them too.
#pragma once

#include "tools/identify/latency/wheel_latency.hpp"

namespace odomd::tools {

/// Of accel_y, over the side force of the turn.
[[nodiscard]] SourceOffset lateral(const GyroDrive& drive, const Speed& speed);

/// Of accel_x, over the change of speed.
[[nodiscard]] SourceOffset longitudinal(const GyroDrive& drive, const Speed& speed);

}  // namespace odomd::tools
