// What filmed circles told, as numbers for the configuration and as a table of the circles.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/identify/common/finding.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"
#include "tools/identify/stiffness/filmed_circles.hpp"

namespace odomd::tools {

/// Throws std::invalid_argument where the circles tell neither axle's stiffness to a quarter.
void require_slip(const CorneringStiffness& found);

/// What the circles say against a sensor, the configuration or the places of the markers, so
/// grossly that no stiffness is to be believed: a line each, with what to look at.
[[nodiscard]] std::vector<std::string> contradictions(const FilmedCircles& films,
                                                      const CorneringStiffness& found,
                                                      const CircleCar& car);

/// Where something is `against` them, the stiffnesses are not determined.
[[nodiscard]] Findings stiffness_findings(const FilmedCircles& films,
                                          const CorneringStiffness& found,
                                          std::span<const std::string> against);

/// A row a circle, for people.
[[nodiscard]] std::string circle_table(const FilmedCircles& films, const CorneringStiffness& found);

}  // namespace odomd::tools
