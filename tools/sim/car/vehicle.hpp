// The cars of the simulation: what a configuration says of them, and what they really are.
#pragma once

#include "estimator/common/vehicle.hpp"
#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

/// What the configuration says.
[[nodiscard]] estimator::Vehicle configured_vehicle(CarKind car);

/// Effective wheel radius that the control units reckon with [m].
[[nodiscard]] double configured_wheel_radius(CarKind car);

/// What is driven: the configured car with the drawn errors of its tyres, mass and inertia, and
/// what no configuration knows of.
[[nodiscard]] PlantParameters true_vehicle(CarKind car, const ParameterSet& truth);

}  // namespace odomd::sim
