// The numbers of a car that no database and no log contains: given as options. A message about
// missing ones has a hint on how to measure each.
#pragma once

#include <string>
#include <vector>

#include "tools/init/proposal.hpp"

namespace odomd::tools {

/// The numbers as given, with their units; empty: not given.
struct CarTexts {
  std::string mass, wheelbase, front_axle, track, wheel_radius, steering_ratio, full_lock,
      gear_ratio, pole_pairs;
};

/// Throws std::invalid_argument naming the option.
[[nodiscard]] Car parse_car(const CarTexts& texts);

/// The options that the proposal needs and that were not given: always mass and wheelbase; the
/// wheel radius for speeds in turns per minute; a motor's gear ratio and pole pairs; the track, if
/// both wheels of an axle are mapped and no gyro measured it; the full lock, if steering is a
/// command and the drive did not show its scale.
[[nodiscard]] std::vector<std::string> missing_numbers(const Car& car, const Proposal& proposal);

/// Throws std::invalid_argument that lists the missing options with their hints, if there are any.
void require_numbers(const Car& car, const Proposal& proposal);

}  // namespace odomd::tools
