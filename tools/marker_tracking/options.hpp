// The command line of odom identify track, for `odom`, which describes and checks it, and for the
// program odom-track, which alone is linked with OpenCV.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/cli/command.hpp"

namespace odomd::tools {

struct TrackOptions {
  std::string film;
  std::string out;
  std::string overlay;                      ///< video of the film with the markers; empty: none
  std::string aruco;                        ///< dictionary: "4x4_50"
  std::optional<int> front, rear;           ///< ArUco identifiers
  std::string lens;                         ///< file with its calibration
  std::vector<std::string> ground_markers;  ///< ID=X,Y
  double height = 0.0;                      ///< of the car's markers above the ground [m]
  std::optional<double> frames_per_second;
  std::string calibrate;  ///< inner corners of a chessboard: "9x6"; empty: track
  double square = 0.0;    ///< edge of a square of the chessboard [m]
};

/// Adds the options, the description and the examples.
void describe_track(Command command, TrackOptions& options);

/// Checks the combination of options. Throws std::invalid_argument.
void check(const TrackOptions& options);

/// An ArUco marker on the ground and the position of its middle [m].
struct GroundMarker {
  int id = 0;
  double x = 0.0, y = 0.0;
};
[[nodiscard]] GroundMarker parse_ground_marker(const std::string& text);

struct BoardSize {
  int columns = 0, rows = 0;  ///< inner corners
};
[[nodiscard]] BoardSize parse_board(const std::string& text);

}  // namespace odomd::tools
