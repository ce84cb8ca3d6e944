#include "tools/marker_tracking/options.hpp"

#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {

GroundMarker parse_ground_marker(const std::string& text) {
  std::istringstream in(text);
  GroundMarker marker;
  char equals = 0, comma = 0;
  in >> marker.id >> equals >> marker.x >> comma >> marker.y;
  if (in.fail() || !in.eof() || marker.id < 0 || equals != '=' || comma != ',')
    throw std::invalid_argument("--ground-marker: " + tools::quoted(text) +
                                " is not ID=X,Y, an ArUco marker and where its middle is on the "
                                "ground [m], such as 0=0,2.5");
  return marker;
}

BoardSize parse_board(const std::string& text) {
  std::istringstream in(text);
  BoardSize board;
  char by = 0;
  in >> board.columns >> by >> board.rows;
  const auto is_possible = [](int corners) { return corners >= 3 && corners <= 100; };
  if (in.fail() || !in.eof() || by != 'x' || !is_possible(board.columns) ||
      !is_possible(board.rows))
    throw std::invalid_argument("--calibrate: " + tools::quoted(text) +
                                " is not COLUMNSxROWS of inner corners, 3x3 or more, such as 9x6");
  return board;
}

void check(const TrackOptions& o) {
  const auto refuse = [](const char* what) { throw std::invalid_argument(what); };
  const std::vector<std::filesystem::path> inputs{o.film, o.lens};
  check_outputs(std::vector<Output>{{"--out", o.out}, {"--overlay", o.overlay}}, inputs);
  if (!o.calibrate.empty()) {
    static_cast<void>(parse_board(o.calibrate));
    if (!(o.square > 0.0)) refuse("--calibrate: give the size of a square: --square 0.025");
    if (o.out.empty()) refuse("--calibrate: give the output file for the lens: --out lens.yaml");
    return;
  }
  if (o.aruco.empty()) refuse("give the markers on the car: --aruco 4x4_50 --front ID --rear ID");
  if (!o.front || !o.rear || *o.front == *o.rear)
    refuse("--aruco: give the ids of both markers: --front ID --rear ID, two different ones");
  for (const std::string& text : o.ground_markers) static_cast<void>(parse_ground_marker(text));
  const std::size_t markers = o.ground_markers.size();
  if (markers > 0 && markers < 4)
    refuse("--ground-marker: give at least four, no three of them in a line");
  if (!(o.height >= 0.0 && o.height < 100.0)) refuse("--height: must lie between 0 and 100 m");
  if (o.height > 0.0 && (o.lens.empty() || markers == 0))
    refuse("--height: needs the lens (--lens) and markers on the ground (--ground-marker)");
  if (o.frames_per_second && !(*o.frames_per_second > 0.0)) refuse("--fps: must be greater than 0");
}

void describe_track(Command command, TrackOptions& options) {
  command.description("Track two markers on the car through a film, for odom identify stiffness");
  command.add("FILM", "", options.film, "Film: a video in any format that FFmpeg reads",
              {required()});
  command.add("--out", "FILE", options.out,
              "Track: CSV of t,x_front,y_front,x_rear,y_rear; default: standard output. With "
              "--calibrate: the lens");
  command.add("--overlay", "FILE", options.overlay,
              "Video (.avi) of the film with what was found: both markers and their tracks");
  const Command markers = command.group("Markers on the car");
  markers.add("--aruco", "DICT", options.aruco,
              "ArUco markers of this dictionary: 4x4_50 to 7x7_1000, original, apriltag_36h11");
  markers.add("--front", "ID", options.front, "Identifier of the front marker");
  markers.add("--rear", "ID", options.rear, "Identifier of the rear marker");
  const Command view = command.group("From pixels to metres");
  view.add("--lens", "FILE", options.lens,
           "Calibration of the lens: camera_matrix and distortion_coefficients as OpenCV writes "
           "them (YAML, XML)");
  view.add(
      "--ground-marker", "ID=X,Y", options.ground_markers,
      "An ArUco marker on the ground and the place of its middle [m]; repeatable: at least "
      "four, and a fifth to detect a mistyped one. Seen from above, y points to the left of x");
  view.add("--height", "H", options.height,
           "Height of the car's markers above the ground [m]; needs --lens; default: 0");
  const Command time = command.group("Time of the frames");
  time.add("--fps", "N", options.frames_per_second,
           "Frames per second as filmed [1/s]; default: the film's own times");
  const Command lens = command.group("Calibration of a lens");
  lens.add("--calibrate", "COLSxROWS", options.calibrate,
           "FILM shows a chessboard with this many inner corners, held at all angles and "
           "everywhere in the picture; writes the lens to --out");
  lens.add("--square", "L", options.square, "Edge of a square of the chessboard [m]");
  command.footer(
      "Print two ArUco markers as large as fits on the car's roof, 20 pixels of the film a side "
      "or\n"
      "more. Film with a short exposure, focus and zoom fixed. A marker that is lost leaves its\n"
      "fields empty. Without markers on the ground the track is in pixels, y down:\n"
      "odom identify stiffness --y-down.\n"
      "\n"
      "Examples:\n"
      "  odom identify track board.mp4 --calibrate 9x6 --square 0.025 --out lens.yaml\n"
      "  odom identify track circles.mp4 --aruco 4x4_50 --front 7 --rear 8 --lens lens.yaml \\\n"
      "    --ground-marker 0=0,0 --ground-marker 1=3,0 --ground-marker 2=3,3 \\\n"
      "    --ground-marker 3=0,3 --ground-marker 4=1,1.5 --height 0.12 --out markers.csv");
}

}  // namespace odomd::tools
