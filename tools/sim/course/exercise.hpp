// The drives of a 1:10 car that odom identify learns from.
#pragma once

#include "tools/sim/course/scenario.hpp"

namespace odomd::sim {

/// For the cornering stiffness: steady circles, left and right, slow to fast. Each begins and ends
/// at the origin, heading along x; `turns` rounds each.
[[nodiscard]] Route circles(double top_speed, int turns);

/// For odom identify fit: circles to both sides and quick weaving, each at several speeds, within
/// half of the grip. Circles `turns` times each, weaving twice as often.
[[nodiscard]] Route exercise(double top_speed, int turns);

}  // namespace odomd::sim
