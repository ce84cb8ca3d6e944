// The drives: which car, where it goes, how fast, and what lies on the road.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tools/sim/car/parameters.hpp"
#include "tools/sim/course/driver.hpp"

namespace odomd::sim {

/// Where a drive goes.
struct Route {
  std::vector<Leg> legs;
  std::vector<FrictionPatch> patches;  ///< their friction is filled in from the parameters
};

struct Scenario {
  std::string_view name;
  std::string_view sentence;
  CarKind car = CarKind::scale_car;  ///< drives where none is named; others of its size may too
  double speed = 1.0;                ///< default [m/s]
  double max_speed = 3.0;
  int laps = 1;  ///< default
  DriverLimits limits;
  Route (*route)(double speed, int laps);
  double grade = 0.0;  ///< of the road [1]; default of road_grade
  double bank = 0.0;   ///< ... and of road_bank [rad]
};

[[nodiscard]] std::span<const Scenario> all_scenarios();

/// By name: the first, or that for cars of a size. Throws std::invalid_argument that names them
/// all.
[[nodiscard]] const Scenario& find_scenario(std::string_view name,
                                            std::optional<CarSize> size = {});

}  // namespace odomd::sim
