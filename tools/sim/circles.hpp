// The drive on which the cornering stiffness is measured: steady circles, left and right, slow to
// fast.
#pragma once

#include "tools/sim/scenario.hpp"

namespace odomd::sim {

/// Each circle begins and ends at the origin, heading along x; `turns` rounds each.
[[nodiscard]] Route circles(double top_speed, int turns);

}  // namespace odomd::sim
