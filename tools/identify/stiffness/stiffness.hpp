// odom identify stiffness: its command line, the circles of its films with the faults that no fit
// could correct, and its results: numbers for the configuration, a table, a picture.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/chart/drawing.hpp"
#include "tools/cli/command.hpp"
#include "tools/identify/common/finding.hpp"
#include "tools/identify/stiffness/circle_runs.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"
#include "tools/identify/stiffness/film.hpp"
#include "tools/replay/log_options.hpp"

namespace odomd::tools {

struct StiffnessOptions {
  std::vector<std::string> runs;
  std::string config;
  std::string front, rear;
  std::optional<double> metres_per_pixel;
  bool metres = false;
  bool y_down = false;
  std::optional<double> frames_per_second;
  std::optional<double> time_offset;
  std::string sigma_mass, sigma_axle, sigma_marker, sigma_scale = "0.3%";
  double rolling_resistance = 0.015;
  std::string plot;
  Delivery delivery;
  can::Damage damage = can::Damage::left_out;
};

/// Checks the options together. Throws std::invalid_argument, as do the following for impossible
/// values.
void check(const StiffnessOptions& options);

/// --front and --rear.
[[nodiscard]] MarkerPlaces marker_places(const StiffnessOptions& options);

/// What one --run names.
struct FilmFiles {
  std::vector<std::string> tracks;  ///< of both markers, or of the front and the rear one
  std::string log;
};
[[nodiscard]] FilmFiles film_files(const std::string& run);

[[nodiscard]] FilmScale film_scale(const StiffnessOptions& options, const MarkerPlaces& places);

/// The configured car, each number with its uncertainty.
[[nodiscard]] CircleCar circle_car(const StiffnessOptions& options, const daemon::Config& config,
                                   const MarkerPlaces& places);

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
