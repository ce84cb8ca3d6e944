// The drive with the most information for odom identify fit: circles to both sides and quick
// weaving, each at several speeds, within half of the grip.
#pragma once

#include "tools/sim/course/scenario.hpp"

namespace odomd::sim {

/// Each part begins and ends at the origin, heading along x; circles `rounds` times each, weaving
/// twice as often.
[[nodiscard]] Route exercise(double top_speed, int rounds);

}  // namespace odomd::sim
