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
  std::string overlay;             ///< video of the film with the markers; empty: none
  std::string aruco;               ///< dictionary: "4x4_50"; empty: none
  std::optional<int> front, rear;  ///< ArUco identifiers
  std::string colour_front, colour_rear;
  std::string lens;                         ///< file with its calibration
  std::vector<std::string> ground;          ///< U,V=X,Y
  std::vector<std::string> ground_markers;  ///< ID=X,Y
  double height = 0.0;                      ///< of the car's markers above the ground [m]
  std::optional<double> frames_per_second;
  std::string frame_times;
  std::string calibrate;  ///< inner corners of a chessboard: "9x6"; empty: track
  double square = 0.0;    ///< edge of a square of the chessboard [m]
  bool progress = false;
};

/// Adds the options, the description and the examples.
void describe_track(Command command, TrackOptions& options);

/// Checks the combination of options. Throws std::invalid_argument.
void check(const TrackOptions& options);

/// A marker's colour: "HUE,SATURATION,BRIGHTNESS[,TOLERANCE]"; degrees, two minima in %, degrees.
struct ColourRange {
  double hue = 0.0;         ///< 0 red, 120 green, 240 blue
  double saturation = 0.0;  ///< lower limit [0, 1]
  double brightness = 0.0;  ///< lower limit [0, 1]
  double tolerance = 15.0;  ///< of the hue, in both directions [degrees]
};
[[nodiscard]] ColourRange parse_colour(const std::string& option, const std::string& text);

/// A point on the ground: "U,V=X,Y" in pixels and metres, or "ID=X,Y".
struct GroundPoint {
  double u = 0.0, v = 0.0;
  int marker = -1;  ///< ArUco identifier; -1: u and v are given
  double x = 0.0, y = 0.0;
};
[[nodiscard]] GroundPoint parse_ground_point(const std::string& text);
[[nodiscard]] GroundPoint parse_ground_marker(const std::string& text);

struct BoardSize {
  int columns = 0, rows = 0;  ///< inner corners
};
[[nodiscard]] BoardSize parse_board(const std::string& text);

}  // namespace odomd::tools
