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

/// The options that a proposal needs and that are not given: mass and wheelbase; a radius for
/// speeds in turns per minute, and the motor's ratios; the track, if both wheels of an axle are
/// mapped and no gyro has measured it; the full lock of a command whose scale no drive has shown.
[[nodiscard]] std::vector<std::string> missing_numbers(const Car& car, const Proposal& proposal);

/// Throws std::invalid_argument that lists the missing options with their hints, if there are any.
void require_numbers(const Car& car, const Proposal& proposal);

}  // namespace odomd::tools
