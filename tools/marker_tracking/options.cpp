#include "tools/marker_tracking/options.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {
namespace {

// Parses "1,2.5" as finite numbers; empty if one of them is not a finite number.
std::vector<double> numbers_of(std::string_view text, char separator = ',') {
  std::vector<double> numbers;
  while (true) {
    const std::size_t length = std::min(text.find(separator), text.size());
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + length, value);
    if (error != std::errc{} || end != text.data() + length || !std::isfinite(value)) return {};
    numbers.push_back(value);
    if (length == text.size()) return numbers;
    text.remove_prefix(length + 1);
  }
}

struct Sides {
  std::vector<double> left, right;
};

Sides sides_of(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return {};
  return {numbers_of(text.substr(0, equals)), numbers_of(text.substr(equals + 1))};
}

}  // namespace

ColourRange parse_colour(const std::string& option, const std::string& text) {
  const std::vector<double> n = numbers_of(text);
  const bool whole = n.size() == 3 || n.size() == 4;
  if (!whole || n[0] < 0.0 || n[0] > 360.0 || n[1] < 0.0 || n[1] > 100.0 || n[2] < 0.0 ||
      n[2] > 100.0 || (n.size() == 4 && !(n[3] > 0.0 && n[3] <= 90.0)))
    throw std::invalid_argument(option + ": " + tools::quoted(text) +
                                " is not HUE,SATURATION,BRIGHTNESS in degrees and least per cents, "
                                "such as 120,40,30 for green");
  return {n[0], 0.01 * n[1], 0.01 * n[2], n.size() == 4 ? n[3] : 15.0};
}

GroundPoint parse_ground_point(const std::string& text) {
  const Sides sides = sides_of(text);
  if (sides.left.size() != 2 || sides.right.size() != 2)
    throw std::invalid_argument("--ground: " + tools::quoted(text) +
                                " is not U,V=X,Y, a place in the picture [px] and on the ground "
                                "[m], such as 102,571=0,2.5");
  return {sides.left[0], sides.left[1], -1, sides.right[0], sides.right[1]};
}

GroundPoint parse_ground_marker(const std::string& text) {
  const Sides sides = sides_of(text);
  const bool id = sides.left.size() == 1 && sides.left[0] >= 0.0 && sides.left[0] < 10'000.0 &&
                  sides.left[0] == std::floor(sides.left[0]);
  if (!id || sides.right.size() != 2)
    throw std::invalid_argument("--ground-marker: " + tools::quoted(text) +
                                " is not ID=X,Y, an ArUco marker and where its middle is on the "
                                "ground [m], such as 0=0,2.5");
  return {0.0, 0.0, static_cast<int>(sides.left[0]), sides.right[0], sides.right[1]};
}

BoardSize parse_board(const std::string& text) {
  const std::vector<double> n = numbers_of(text, 'x');
  if (n.size() != 2 || n[0] != std::floor(n[0]) || n[1] != std::floor(n[1]) || n[0] < 3.0 ||
      n[1] < 3.0 || n[0] > 100.0 || n[1] > 100.0)
    throw std::invalid_argument("--calibrate: " + tools::quoted(text) +
                                " is not COLUMNSxROWS of inner corners, 3x3 or more, such as 9x6");
  return {static_cast<int>(n[0]), static_cast<int>(n[1])};
}

void check(const TrackOptions& o) {
  const auto refuse = [](const char* what) { throw std::invalid_argument(what); };
  const std::vector<std::filesystem::path> inputs{o.film, o.lens, o.frame_times};
  check_outputs(std::vector<Output>{{"--out", o.out}, {"--overlay", o.overlay}}, inputs);
  if (!o.calibrate.empty()) {
    static_cast<void>(parse_board(o.calibrate));
    if (!(o.square > 0.0)) refuse("--calibrate: give the size of a square: --square 0.025");
    if (o.out.empty()) refuse("--calibrate: give the output file for the lens: --out lens.yaml");
    return;
  }
  const bool colours = !o.colour_front.empty() || !o.colour_rear.empty();
  if (o.aruco.empty() == !colours)
    refuse(
        "give one kind of marker: --aruco 4x4_50 --front ID --rear ID, or --colour-front and "
        "--colour-rear");
  if (colours) {
    if (o.colour_front.empty() || o.colour_rear.empty())
      refuse("--colour-front and --colour-rear: both are needed, and different");
    static_cast<void>(parse_colour("--colour-front", o.colour_front));
    static_cast<void>(parse_colour("--colour-rear", o.colour_rear));
    if (!o.ground_markers.empty()) refuse("--ground-marker: needs --aruco; give points: --ground");
  } else if (!o.front || !o.rear || *o.front == *o.rear) {
    refuse("--aruco: give the ids of both markers: --front ID --rear ID, two different ones");
  }
  if (!o.ground.empty() && !o.ground_markers.empty())
    refuse("--ground and --ground-marker: give only one of them");
  const std::size_t points = o.ground.size() + o.ground_markers.size();
  if (points > 0 && points < 4)
    refuse("--ground, --ground-marker: give at least four places, no three of them in a line");
  for (const std::string& text : o.ground) static_cast<void>(parse_ground_point(text));
  for (const std::string& text : o.ground_markers) static_cast<void>(parse_ground_marker(text));
  if (!(o.height >= 0.0 && o.height < 100.0)) refuse("--height: must lie between 0 and 100 m");
  if (o.height > 0.0 && (o.lens.empty() || points == 0))
    refuse("--height: needs the lens (--lens) and places on the ground (--ground)");
  if (o.frames_per_second && !(*o.frames_per_second > 0.0)) refuse("--fps: must be greater than 0");
  if (o.frames_per_second && !o.frame_times.empty())
    refuse("--fps and --frame-times: give one of them");
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
  markers.add("--colour-front", "H,S,V[,T]", options.colour_front,
              "Coloured front marker: hue [degrees], least saturation and brightness [%], and "
              "tolerance of the hue [degrees]; default: 15");
  markers.add("--colour-rear", "H,S,V[,T]", options.colour_rear,
              "Coloured rear marker, of another colour");
  const Command view = command.group("From pixels to metres");
  view.add("--lens", "FILE", options.lens,
           "Calibration of the lens: camera_matrix and distortion_coefficients as OpenCV writes "
           "them (YAML, XML)");
  view.add("--ground", "U,V=X,Y", options.ground,
           "A place in the picture [px] and on the ground [m]; repeatable: at least four, and a "
           "fifth to detect a mistyped one. Seen from above, y points to the left of x");
  view.add("--ground-marker", "ID=X,Y", options.ground_markers,
           "An ArUco marker on the ground and the place of its middle [m]; repeatable, as many as "
           "--ground");
  view.add("--height", "H", options.height,
           "Height of the car's markers above the ground [m]; needs --lens; default: 0");
  const Command time = command.group("Time of the frames");
  time.add("--fps", "N", options.frames_per_second,
           "Frames per second as filmed [1/s]; default: the film's own times");
  time.add("--frame-times", "CSV", options.frame_times,
           "Times of the frames: CSV with the column t [s], one row per frame");
  const Command lens = command.group("Calibration of a lens");
  lens.add("--calibrate", "COLSxROWS", options.calibrate,
           "FILM shows a chessboard with this many inner corners, held at all angles and "
           "everywhere in the picture; writes the lens to --out");
  lens.add("--square", "L", options.square, "Edge of a square of the chessboard [m]");
  command.add_flag("--progress", options.progress, "Show progress even without a terminal");
  command.footer(
      "Print two ArUco markers as large as the car's roof takes, 20 pixels of the film a side or\n"
      "more, or stick on two spots of colours that are nowhere else. Film with a short exposure,\n"
      "focus and zoom fixed. A marker that is lost leaves its fields empty. Without places on the\n"
      "ground the track is in pixels, y down: odom identify stiffness --y-down.\n"
      "\n"
      "Examples:\n"
      "  odom identify track board.mp4 --calibrate 9x6 --square 0.025 --out lens.yaml\n"
      "  odom identify track circles.mp4 --aruco 4x4_50 --front 7 --rear 8 --lens lens.yaml \\\n"
      "    --ground-marker 0=0,0 --ground-marker 1=3,0 --ground-marker 2=3,3 \\\n"
      "    --ground-marker 3=0,3 --ground-marker 4=1,1.5 --height 0.12 --out markers.csv\n"
      "  odom identify track circles.mp4 --colour-front 120,40,30 --colour-rear 340,50,40 \\\n"
      "    --out markers.csv");
}

}  // namespace odomd::tools
