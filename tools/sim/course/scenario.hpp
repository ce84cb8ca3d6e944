// The scenarios: car, route, speed, and patches on the road.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tools/sim/car/parameters.hpp"
#include "tools/sim/course/driver.hpp"

namespace odomd::sim {

/// The route of a drive.
struct Route {
  std::vector<Leg> legs;
  std::vector<FrictionPatch> patches;  ///< with the friction from the parameters
};

struct Scenario {
  std::string_view name;
  std::string_view sentence;
  CarKind car = CarKind::scale_car;  ///< default; other cars of its size are allowed
  double speed = 1.0;                ///< default [m/s]
  double max_speed = 3.0;
  int laps = 1;  ///< default
  DriverLimits limits;
  std::function<Route(double speed, int laps)> route;
  double grade = 0.0;  ///< default of the parameter road_grade [1]
  double bank = 0.0;   ///< default of the parameter road_bank [rad]
};

[[nodiscard]] std::span<const Scenario> all_scenarios();

/// The first scenario with this name (if `size` is given, among those for cars of this size).
/// Throws std::invalid_argument with all names.
[[nodiscard]] const Scenario& find_scenario(std::string_view name,
                                            std::optional<CarSize> size = {});

}  // namespace odomd::sim
