// The command line of odom identify stiffness, and its numbers for film and car.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/core/config.hpp"
#include "tools/cli/command.hpp"
#include "tools/identify/common/delivery.hpp"
#include "tools/identify/stiffness/cornering_stiffness.hpp"
#include "tools/identify/stiffness/film_motion.hpp"
#include "tools/identify/stiffness/marker_track.hpp"

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
};

/// Adds the options, the description and the examples.
void describe_stiffness(Command command, StiffnessOptions& options);

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

}  // namespace odomd::tools
