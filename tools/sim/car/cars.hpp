// The cars of the simulation, three of them full-size with published data: their configured and
// their true parameters.
#pragma once

#include <string>
#include <string_view>

#include "estimator/common/vehicle.hpp"
#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

/// The names of all cars for `--car`, separated by '|'.
[[nodiscard]] std::string car_names();

/// Throws std::invalid_argument with all names.
[[nodiscard]] CarKind find_car(std::string_view name);

[[nodiscard]] std::string_view car_name(CarKind car);

/// A sprung car with its published parameters, which its owner knows: cornering stiffnesses are
/// those of the tyres under the static load. All wheels have the published radius.
[[nodiscard]] PlantParameters published_car(CarKind car);

/// The configured car.
[[nodiscard]] estimator::Vehicle configured_vehicle(CarKind car);

/// The effective wheel radius with which the control units compute speeds [m].
[[nodiscard]] double configured_wheel_radius(CarKind car);

/// The simulated car: the configured one with the drawn errors of its tyres, mass and inertia, and
/// properties that are not in a configuration.
[[nodiscard]] PlantParameters true_vehicle(CarKind car, const ParameterSet& truth);

}  // namespace odomd::sim
