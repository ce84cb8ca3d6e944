#include "tools/marker_tracking/track_film.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "tools/cli/csv.hpp"
#include "tools/cli/text.hpp"
#include "tools/marker_tracking/film.hpp"
#include "tools/marker_tracking/markers.hpp"
#include "tools/marker_tracking/view.hpp"

namespace odomd::tools {
namespace {

// Finds the front and the rear marker.
FindMarkers finder_of(const TrackOptions& options) {
  if (!options.aruco.empty())
    return aruco_finder(options.aruco, {options.front.value(), options.rear.value()});
  return colour_finder({parse_colour("--colour-front", options.colour_front),
                        parse_colour("--colour-rear", options.colour_rear)});
}

// The middles of the ground markers, each the mean of up to ten frames: the camera does not move.
std::vector<GroundPoint> find_ground(const TrackOptions& options) {
  std::vector<GroundPoint> points;
  for (const std::string& text : options.ground) points.push_back(parse_ground_point(text));
  if (options.ground_markers.empty()) return points;

  constexpr std::int64_t frames = 300;
  constexpr std::size_t enough = 10;
  std::vector<int> identifiers;
  for (const std::string& text : options.ground_markers) {
    points.push_back(parse_ground_marker(text));
    identifiers.push_back(points.back().marker);
    if (std::ranges::count(identifiers, identifiers.back()) > 1 ||
        identifiers.back() == options.front || identifiers.back() == options.rear)
      throw std::invalid_argument(
          fmt::format("--ground-marker: marker {} is named twice", identifiers.back()));
  }
  std::vector<std::vector<cv::Point2d>> seen(points.size());
  const FindMarkers find = aruco_finder(options.aruco, identifiers);
  FilmReader film(options);
  while (film.count() < frames && film.next()) {
    const std::vector<MarkerPixel> found = find(film.picture());
    for (std::size_t k = 0; k < found.size(); ++k)
      if (found[k]) seen[k].push_back(*found[k]);
    if (std::ranges::all_of(seen, [](const auto& places) { return places.size() >= enough; }))
      break;
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (seen[k].empty())
      throw std::invalid_argument(fmt::format(
          "{}: marker {} is not seen on the ground in its first {}; check its number, its size in "
          "the picture and the light, or give places with --ground",
          options.film, identifiers[k],
          counted(static_cast<std::uint64_t>(film.count()), "frame")));
    for (const cv::Point2d& place : seen[k]) {
      points[k].u += place.x / static_cast<double>(seen[k].size());
      points[k].v += place.y / static_cast<double>(seen[k].size());
    }
  }
  return points;
}

std::string seconds_text(std::int64_t t_ns) {
  std::string text;
  append_seconds(text, t_ns);
  return text;
}

void append(std::string& line, const MarkerPixel& place, int decimals) {
  line += place ? "," + fixed(place->x, decimals) + "," + fixed(place->y, decimals) : ",,";
}

void require_found(const TrackOptions& options, std::int64_t found, const char* which,
                   std::int64_t frames) {
  if (found > 0) return;
  const std::string why = options.aruco.empty()
                              ? "check its colour (hue, least saturation, least brightness) in a "
                                "frame of the film"
                              : "check dictionary and identifier; a square of it should be 3 "
                                "pixels at least, with a white rim around the marker";
  throw std::invalid_argument(
      fmt::format("{}: the {} marker is in none of its {}; {}", options.film, which,
                  counted(static_cast<std::uint64_t>(frames), "frame"), why));
}

}  // namespace

TrackSummary track_film(const TrackOptions& options, std::ostream& track) {
  std::optional<Lens> lens;
  if (!options.lens.empty()) lens = read_lens(options.lens);
  FilmReader film(options);
  if (lens && lens->picture.area() > 0 && lens->picture != film.size())
    throw std::invalid_argument(
        fmt::format("{}: is of a picture of {} x {}, and the film has {} x {}; calibrate with the "
                    "same settings",
                    options.lens, lens->picture.width, lens->picture.height, film.size().width,
                    film.size().height));
  const FindMarkers find = finder_of(options);
  std::optional<GroundView> view;
  TrackSummary summary;
  const std::vector<GroundPoint> ground = find_ground(options);
  if (!ground.empty()) {
    view.emplace(ground, lens, options.height);
    if (ground.size() > 4)
      summary.notes.push_back(
          fmt::format("the places on the ground agree with the picture to {:.2g} "
                      "mm rms",
                      1e3 * view->misfit()));
  }

  track << "t,x_front,y_front,x_rear,y_rear\n";
  std::optional<Overlay> overlay;
  if (!options.overlay.empty())
    overlay.emplace(options.overlay, options.frames_per_second.value_or(film.rate()), film.size());
  std::int64_t both = 0, gap = 0;
  FrameProgress progress(options.progress);
  while (film.next()) {
    std::vector<MarkerPixel> found = find(film.picture());
    if (found[0]) ++summary.front;
    if (found[1]) ++summary.rear;
    if (overlay)
      overlay->add(film.picture().clone(), found,
                   fixed(1e-9 * static_cast<double>(film.t_ns()), 2) + " s");
    const bool whole = found[0] && found[1];
    both += whole ? 1 : 0;
    gap = whole ? 0 : gap + 1;
    summary.longest_gap = std::max(summary.longest_gap, gap);
    for (MarkerPixel& place : found) {
      if (!place) continue;
      if (view)
        place = view->at(*place);
      else if (lens)
        place = lens->straightened(*place);
    }
    std::string line = seconds_text(film.t_ns());
    const int decimals = view ? 6 : 3;
    append(line, found[0], decimals);
    append(line, found[1], decimals);
    track << line << '\n';
    progress.update(film.count(), film.total(), both);
  }
  summary.frames = film.count();
  if (summary.frames == 0)
    throw std::invalid_argument(
        fmt::format("{}: contains no frame that can be read", options.film));
  require_found(options, summary.front, "front", summary.frames);
  require_found(options, summary.rear, "rear", summary.frames);
  return summary;
}

}  // namespace odomd::tools
