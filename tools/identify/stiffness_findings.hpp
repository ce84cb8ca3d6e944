// What filmed circles told, as numbers for the configuration and as a table of the circles.
#pragma once

#include <string>

#include "tools/identify/cornering_stiffness.hpp"
#include "tools/identify/filmed_circles.hpp"
#include "tools/identify/finding.hpp"

namespace odomd::tools {

/// Throws std::invalid_argument where the circles tell neither axle's stiffness to a quarter.
void require_slip(const CorneringStiffness& found);

[[nodiscard]] Findings stiffness_findings(const FilmedCircles& films,
                                          const CorneringStiffness& found);

/// A row a circle, for people.
[[nodiscard]] std::string circle_table(const FilmedCircles& films, const CorneringStiffness& found);

}  // namespace odomd::tools
