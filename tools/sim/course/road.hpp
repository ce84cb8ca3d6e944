// Hills and banked turns along a track.
#pragma once

#include "tools/sim/car/chassis.hpp"
#include "tools/sim/course/track.hpp"

namespace odomd::sim {

/// How far a road departs from a level one.
struct RoadProfile {
  double grade = 0.0;  ///< steepest [1]
  double bank = 0.0;   ///< most, in its curves, their outer side up [rad]

  [[nodiscard]] bool is_level() const { return grade == 0.0 && bank == 0.0; }
};

/// At arc length `s` of a closed track, for a car that goes along it with `speed` [m/s]. Ends where
/// it began in height; level at its start, and all of it where a track is open.
[[nodiscard]] RoadTilt tilt_at(const RoadProfile& profile, const Track& track, double s,
                               double speed);

}  // namespace odomd::sim
