// The cars of the simulation: their configured and their true parameters.
#pragma once

#include "estimator/common/vehicle.hpp"
#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

/// The configured car.
[[nodiscard]] estimator::Vehicle configured_vehicle(CarKind car);

/// Effective wheel radius that the control units reckon with [m].
[[nodiscard]] double configured_wheel_radius(CarKind car);

/// The simulated car: the configured one with the drawn errors of its tyres, mass and inertia, and
/// properties that are not in a configuration.
[[nodiscard]] PlantParameters true_vehicle(CarKind car, const ParameterSet& truth);

}  // namespace odomd::sim
