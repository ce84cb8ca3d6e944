// Three full-size cars with published data.
#pragma once

#include <string>
#include <string_view>

#include "tools/sim/car/parameters.hpp"
#include "tools/sim/car/plant.hpp"

namespace odomd::sim {

/// All cars as `--car` names them, separated by '|'.
[[nodiscard]] std::string car_names();

/// Throws std::invalid_argument that names them all.
[[nodiscard]] CarKind find_car(std::string_view name);

[[nodiscard]] std::string_view car_name(CarKind car);

/// A sprung car as published, and what its owner can read of that: cornering stiffnesses are those
/// of the tyres under the static load. Wheel radii are the published one.
[[nodiscard]] PlantParameters published_car(CarKind car);

}  // namespace odomd::sim
