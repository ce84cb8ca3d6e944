// The drive on which the cornering stiffness is measured: steady circles, left and right, slow to
// fast.
#pragma once

#include <memory>

#include "tools/sim/course/scenario.hpp"

namespace odomd::sim {

/// Through the origin, heading along x, round to the left for a positive radius.
[[nodiscard]] std::shared_ptr<const Track> circle_through_origin(double radius);

/// Each circle begins and ends at the origin, heading along x; `turns` rounds each.
[[nodiscard]] Route circles(double top_speed, int turns);

}  // namespace odomd::sim
