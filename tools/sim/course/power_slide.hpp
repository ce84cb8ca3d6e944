// How the driver holds the car in a power slide: the throttle spins the rear wheels, whose grip is
// then spent, and the front wheels, turned against the curve, keep the sideslip angle.
#pragma once

#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

/// What a slide is to follow.
struct SlideTarget {
  double sideslip = 0.0;   ///< β [rad], against the curve: negative in one to the left
  double curvature = 0.0;  ///< of the path [1/m], positive to the left
};

/// For a car with rear-wheel drive that slides through a curve.
[[nodiscard]] PlantInput hold_slide(const PlantParameters& car, const PlantOutput& now,
                                    const SlideTarget& target);

}  // namespace odomd::sim
