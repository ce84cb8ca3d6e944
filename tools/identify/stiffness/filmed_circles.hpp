// The circles of several films, each aligned with its log, and faults that no fit could correct.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/identify/stiffness/circle_runs.hpp"
#include "tools/identify/stiffness/film_alignment.hpp"
#include "tools/identify/stiffness/stiffness_options.hpp"

namespace odomd::tools {

struct FilmedCircles {
  std::vector<CircleRun> circles;
  std::vector<std::string> names;         ///< of the films
  std::vector<FilmAlignment> alignments;  ///< of each film; offset after the log's first frame
  diagnostics::Diagnostics warnings;
};

/// Throws std::invalid_argument for an unusable film or log, and if no film has a steady circle.
[[nodiscard]] FilmedCircles measure_films(const StiffnessOptions& options,
                                          const daemon::Config& config, const MarkerPlaces& places);

/// Throws std::invalid_argument if most circles are driven backwards or sideways, or steered the
/// wrong way or by another measure: markers or their X and Y exchanged, sign or scale of the
/// steering.
void check_circles(std::span<const CircleRun> circles, double wheelbase);

/// Beyond this difference film and accelerometer cannot both be right.
inline constexpr double gross_scale_error = 0.15;

/// The log's lateral acceleration over the film's v_x ψ̇: shows a wrong scale of the film. Nothing
/// if there is too little of either.
[[nodiscard]] std::optional<Measured> accelerometer_slope(std::span<const CircleRun> circles);

/// Warnings: what a fit cannot separate without circles of another kind, and an accelerometer that
/// contradicts the film's scale.
[[nodiscard]] diagnostics::Diagnostics circle_warnings(std::span<const CircleRun> circles);

}  // namespace odomd::tools
