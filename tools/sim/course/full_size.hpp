// Where full-size cars drive: the routes of the scenarios of scenario.hpp that are theirs.
#pragma once

#include "tools/sim/course/scenario.hpp"

namespace odomd::sim {

/// Laps of a handling course of 1.2 km: a long straight, curves of 22 to 60 m radius.
[[nodiscard]] Route course_laps(double speed, int laps);

/// The same with stops, no two alike.
[[nodiscard]] Route course_stops(double speed, int laps);

/// A steady turn to the left, 40 m radius.
[[nodiscard]] Route skid_pad(double speed, int laps);

/// Out through cones so far apart that they ask for 4.5 m/s² at the speed, and back.
[[nodiscard]] Route cone_slalom(double speed, int laps);

/// Into a bay in reverse, out, to the kerb, out, and home in reverse.
[[nodiscard]] Route car_park(double speed, int laps);

/// An oval whose half circles, to the left, have a radius of 45 m.
[[nodiscard]] Route banked_oval(double speed, int laps);

/// A winding country road of 1.5 km that closes.
[[nodiscard]] Route country_road(double speed, int laps);

}  // namespace odomd::sim
