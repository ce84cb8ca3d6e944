// The circles of all films: faults that no fit could correct, and the results of the fit as numbers
// for the configuration, a table and a picture.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/chart/picture.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/stiffness/circle_runs.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"
#include "tools/identify/stiffness/film.hpp"

namespace odomd::tools {

struct FilmedCircles {
  std::vector<CircleRun> circles;
  std::vector<FilmAlignment> alignments;  ///< offsets from the log's first frame
  diagnostics::Diagnostics warnings;
};

/// Throws std::invalid_argument if most circles are driven backwards or sideways, or if the
/// steering has the wrong sign or a wrong size: markers or their X and Y exchanged, sign or scale
/// of the steering.
void check_circles(std::span<const CircleRun> circles, double wheelbase);

/// Warnings: parameters that a fit cannot separate without other circles, and an accelerometer that
/// contradicts the film's scale.
[[nodiscard]] diagnostics::Diagnostics circle_warnings(std::span<const CircleRun> circles);

/// Throws std::invalid_argument if the circles determine neither axle's stiffness to a quarter.
void require_slip(const CorneringStiffness& found);

/// Contradictions between the circles and a sensor, the configuration or the markers' positions
/// that are so large that the stiffness cannot be trusted.
[[nodiscard]] diagnostics::Diagnostics contradictions(const FilmedCircles& films,
                                                      const CorneringStiffness& found,
                                                      const CircleCar& car);

/// If `against` has entries, the stiffnesses are not determined.
[[nodiscard]] Findings stiffness_findings(const FilmedCircles& films,
                                          const CorneringStiffness& found,
                                          const diagnostics::Diagnostics& against);

/// Front axle, rear axle.
[[nodiscard]] std::vector<chart::Drawing> draw_stiffness(const CorneringStiffness& found);

}  // namespace odomd::tools
