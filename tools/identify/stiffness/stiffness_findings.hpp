// The results of filmed circles: numbers for the configuration, a table of the circles, a picture.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/chart/drawing.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"
#include "tools/identify/stiffness/filmed_circles.hpp"

namespace odomd::tools {

/// Throws std::invalid_argument if the circles determine neither axle's stiffness to a quarter.
void require_slip(const CorneringStiffness& found);

/// Contradictions between the circles and a sensor, the configuration or the places of the markers,
/// so grossly that the stiffness cannot be trusted.
[[nodiscard]] diagnostics::Diagnostics contradictions(const FilmedCircles& films,
                                                      const CorneringStiffness& found,
                                                      const CircleCar& car);

/// With entries in `against` the stiffnesses are not determined.
[[nodiscard]] Findings stiffness_findings(const FilmedCircles& films,
                                          const CorneringStiffness& found,
                                          const diagnostics::Diagnostics& against);

/// A table with one row per circle.
[[nodiscard]] std::string circle_table(const FilmedCircles& films, const CorneringStiffness& found);

/// Front axle, rear axle.
[[nodiscard]] std::vector<chart::Drawing> draw_stiffness(const CorneringStiffness& found);

}  // namespace odomd::tools
