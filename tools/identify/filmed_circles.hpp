// The circles of several films, each laid on its log, and what of them no fit could mend.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "tools/identify/circle_runs.hpp"
#include "tools/identify/film_alignment.hpp"
#include "tools/identify/stiffness_options.hpp"

namespace odomd::tools {

struct FilmedCircles {
  std::vector<CircleRun> circles;
  std::vector<std::string> names;         ///< of the films
  std::vector<FilmAlignment> alignments;  ///< of each film; offset after the log's first frame
  std::vector<std::string> warnings;
};

/// Throws std::invalid_argument for a film or a log that cannot be used, and where no film has a
/// steady circle.
[[nodiscard]] FilmedCircles measure_films(const StiffnessOptions& options,
                                          const daemon::Config& config, const MarkerPlaces& places);

/// Throws std::invalid_argument where most circles are driven backwards or sideways, or steered the
/// wrong way: markers or their X and Y exchanged, a sign of the steering.
void check_directions(std::span<const CircleRun> circles);

/// What a fit will not tell apart without circles of another kind, and an accelerometer that
/// contradicts the film's scale.
[[nodiscard]] std::vector<std::string> doubts_about(std::span<const CircleRun> circles);

}  // namespace odomd::tools
