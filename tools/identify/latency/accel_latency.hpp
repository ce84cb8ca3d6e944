// Latencies of accelerations, compared with speed and turn. They are also affected by tyres and
// slopes.
#pragma once

#include "tools/identify/latency/wheel_latency.hpp"

namespace odomd::tools {

/// Of accel_y, compared with the side force of the turn.
[[nodiscard]] SourceOffset lateral(const GyroDrive& drive, const Speed& speed);

/// Of accel_x, compared with the change of speed.
[[nodiscard]] SourceOffset longitudinal(const GyroDrive& drive, const Speed& speed);

}  // namespace odomd::tools
