// What routes are made of, for cars of any size.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "tools/sim/course/scenario.hpp"

namespace odomd::sim {

using TrackPointer = std::shared_ptr<const Track>;

/// Straights between rounded corners, as points with this spacing.
[[nodiscard]] TrackPointer polygon(const std::vector<Corner>& corners, Shape shape, double spacing,
                                   double smoothing);

/// Through the origin, heading along x, round to the left for a positive radius.
[[nodiscard]] TrackPointer circle_through_origin(double radius, double smoothing);

/// Out along x in waves that fade in and out, a turn to the left, back in waves, and a turn.
struct Weave {
  double length = 0.0;     ///< of the way out [m]
  double wave = 0.0;       ///< length of a wave [m]
  double amplitude = 0.0;  ///< [m]
  double gap = 0.0;        ///< from the way out to the way back [m]
  int points = 0;          ///< of each of the four parts
};
[[nodiscard]] TrackPointer weaving(const Weave& weave, double smoothing);

/// Round a closed track `laps` times, and a stop on the start line.
[[nodiscard]] Route rounds(const TrackPointer& track, double speed, int laps);

/// The same with a stop after each of the stretches in turn [m], but for one that would be followed
/// by less than `least`.
[[nodiscard]] Route rounds_with_stops(const TrackPointer& track, std::span<const double> stretches,
                                      double least, double speed, int laps);

/// A line between corners that is driven at `pace` times the speed.
struct Move {
  std::vector<Corner> corners;
  double pace = 1.0;
  Gear gear = Gear::forward;
};
[[nodiscard]] Route manoeuvres(const std::vector<Move>& moves, double spacing, double smoothing,
                               double speed, int laps);

}  // namespace odomd::sim
