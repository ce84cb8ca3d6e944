#include "tools/marker_tracking/film.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

using MarkerPixel = std::optional<cv::Point2d>;

// In the order of OpenCV's enumeration.
constexpr std::array<std::string_view, 21> dictionaries{
    "4x4_50",        "4x4_100",        "4x4_250",       "4x4_1000", "5x5_50",   "5x5_100",
    "5x5_250",       "5x5_1000",       "6x6_50",        "6x6_100",  "6x6_250",  "6x6_1000",
    "7x7_50",        "7x7_100",        "7x7_250",       "7x7_1000", "original", "apriltag_16h5",
    "apriltag_25h9", "apriltag_36h10", "apriltag_36h11"};
static_assert(cv::aruco::DICT_APRILTAG_36h11 == dictionaries.size() - 1);

// The intersection of the diagonals, also in perspective: a + t (c - a) = b + u (d - b).
cv::Point2d crossing(const std::vector<cv::Point2f>& corners) {
  const cv::Point2d a = corners[0], b = corners[1], c = corners[2], d = corners[3];
  const cv::Point2d ac = c - a, bd = d - b;
  const double t = (b - a).cross(bd) / ac.cross(bd);
  return a + t * ac;
}

/// Finds ArUco markers with subpixel accuracy.
class MarkerFinder {
 public:
  MarkerFinder(const std::string& dictionary, std::vector<int> identifiers)
      : identifiers_(std::move(identifiers)) {
    const auto* const found = std::ranges::find(dictionaries, dictionary);
    if (found == dictionaries.end())
      throw std::invalid_argument(fmt::format("--aruco: no dictionary {}; available: {}",
                                              tools::quoted(dictionary),
                                              fmt::join(dictionaries, ", ")));
    markers_ = cv::aruco::getPredefinedDictionary(static_cast<int>(found - dictionaries.begin()));
    parameters_->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
    parameters_->cornerRefinementWinSize = 3;
    // Markers on cars are small if the picture shows a whole circle.
    parameters_->minMarkerPerimeterRate = 0.01;
  }

  /// The middle of each marker; nothing for one that is not exactly once in the picture.
  [[nodiscard]] std::vector<MarkerPixel> find(const cv::Mat& picture) const {
    cv::Mat grey;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> found;
    cv::aruco::detectMarkers(grey, markers_, corners, found, parameters_);
    std::vector<MarkerPixel> middles(identifiers_.size());
    for (std::size_t k = 0; k < identifiers_.size(); ++k) {
      if (std::ranges::count(found, identifiers_[k]) != 1) continue;
      const auto index = std::ranges::find(found, identifiers_[k]) - found.begin();
      middles[k] = crossing(corners[static_cast<std::size_t>(index)]);
    }
    return middles;
  }

 private:
  std::vector<int> identifiers_;
  cv::Ptr<cv::aruco::Dictionary> markers_;
  cv::Ptr<cv::aruco::DetectorParameters> parameters_ = cv::aruco::DetectorParameters::create();
};

// The middles of the ground markers, each the mean of up to ten frames: the camera does not move.
std::vector<GroundPoint> find_ground(const TrackOptions& options) {
  std::vector<GroundPoint> points;
  if (options.ground_markers.empty()) return points;

  constexpr std::int64_t frames = 300;
  constexpr std::size_t enough = 10;
  std::vector<int> identifiers;
  for (const std::string& text : options.ground_markers) {
    const GroundMarker marker = parse_ground_marker(text);
    points.push_back({{}, {marker.x, marker.y}});
    if (std::ranges::count(identifiers, marker.id) > 0 || marker.id == options.front ||
        marker.id == options.rear)
      throw std::invalid_argument(
          fmt::format("--ground-marker: marker {} is named twice", marker.id));
    identifiers.push_back(marker.id);
  }
  std::vector<std::vector<cv::Point2d>> seen(points.size());
  const MarkerFinder finder(options.aruco, identifiers);
  FilmReader film(options);
  while (film.count() < frames && film.next()) {
    const std::vector<MarkerPixel> found = finder.find(film.picture());
    for (std::size_t k = 0; k < found.size(); ++k)
      if (found[k]) seen[k].push_back(*found[k]);
    if (std::ranges::all_of(seen, [](const auto& pixels) { return pixels.size() >= enough; }))
      break;
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (seen[k].empty())
      throw std::invalid_argument(fmt::format(
          "{}: marker {} is not seen on the ground in its first {}; check its number, its size in "
          "the picture and the light",
          options.film, identifiers[k],
          counted(static_cast<std::uint64_t>(film.count()), "frame")));
    for (const cv::Point2d& pixel : seen[k])
      points[k].pixel += pixel / static_cast<double>(seen[k].size());
  }
  return points;
}

/// A video of the film: both markers in a ring, front green and rear red, and their tracks so far.
class Overlay {
 public:
  Overlay(const std::string& file, double rate, cv::Size picture)
      : video_(open_video(file, rate, picture)) {}

  void add(cv::Mat picture, const std::vector<MarkerPixel>& found, std::int64_t t_ns) {
    const std::array<cv::Scalar, 2> colours{cv::Scalar(0, 200, 0), cv::Scalar(0, 0, 220)};
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found[i]) tracks_[i].emplace_back(*found[i]);
      cv::polylines(picture, tracks_[i], false, colours[i], 1, cv::LINE_AA);
      if (found[i]) cv::circle(picture, tracks_[i].back(), 12, colours[i], 2, cv::LINE_AA);
    }
    cv::putText(picture, fixed(1e-9 * static_cast<double>(t_ns), 2) + " s", {10, picture.rows - 12},
                cv::FONT_HERSHEY_SIMPLEX, 0.6, cv::Scalar(255, 255, 255), 1, cv::LINE_AA);
    video_.write(picture);
  }

 private:
  cv::VideoWriter video_;
  std::array<std::vector<cv::Point>, 2> tracks_;
};

}  // namespace

FilmReader::FilmReader(const TrackOptions& options)
    : name_(options.film), frames_per_second_(options.frames_per_second) {
  static_cast<void>(open_input(name_));  // unlike OpenCV, it reports what is wrong with the file
  // Only these two of OpenCV's backends: some others search for USB cameras.
  if (!capture_.open(name_, cv::CAP_FFMPEG) && !capture_.open(name_, cv::CAP_OPENCV_MJPEG))
    throw std::invalid_argument(fmt::format(
        "{}: cannot be read as a film; convert it to MP4 or AVI: ffmpeg -i FILM film.mp4", name_));
  size_ = {static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
           static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT))};
}

bool FilmReader::next() {
  if (!capture_.read(picture_) || picture_.empty()) return false;
  size_ = picture_.size();
  const std::int64_t time =
      frames_per_second_ ? std::llround(1e9 * static_cast<double>(count_) / *frames_per_second_)
                         : std::llround(1e6 * capture_.get(cv::CAP_PROP_POS_MSEC));
  if (count_ > 0 && time <= t_ns_)
    throw std::invalid_argument(fmt::format(
        "{}: the times of its frames do not increase at frame {}; give their rate with --fps",
        name_, count_));
  t_ns_ = time;
  ++count_;
  return true;
}

std::string FilmReader::progress() const {
  const double total = capture_.get(cv::CAP_PROP_FRAME_COUNT);
  return fmt::format("frame {}{}", count_,
                     total > 0.0 && total < 1e9 ? fmt::format(" of {:.0f}", total) : "");
}

cv::VideoWriter open_video(const std::filesystem::path& file, double rate, cv::Size picture) {
  cv::VideoWriter video(file.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate, picture);
  if (!video.isOpened())
    throw std::invalid_argument(
        fmt::format("{}: cannot be written as a video; name it .avi", file.string()));
  video.set(cv::VIDEOWRITER_PROP_QUALITY, 90);
  return video;
}

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
  const MarkerFinder finder(options.aruco, {options.front.value(), options.rear.value()});
  std::optional<GroundView> view;
  TrackSummary summary;
  const std::vector<GroundPoint> ground = find_ground(options);
  if (!ground.empty()) {
    view.emplace(ground, lens, options.height);
    if (ground.size() > 4)
      summary.notes.push_back(
          fmt::format("the places on the ground agree with the picture to {:.2g} mm rms",
                      1e3 * view->misfit()));
  }

  track << "t,x_front,y_front,x_rear,y_rear\n";
  std::optional<Overlay> overlay;
  if (!options.overlay.empty())
    overlay.emplace(options.overlay, options.frames_per_second.value_or(film.rate()), film.size());
  std::int64_t gap = 0;
  ProgressLine progress("odom identify track", WithoutTerminal::nothing);
  while (film.next()) {
    const std::vector<MarkerPixel> found = finder.find(film.picture());
    if (found[0]) ++summary.front;
    if (found[1]) ++summary.rear;
    if (overlay) overlay->add(film.picture().clone(), found, film.t_ns());
    gap = found[0] && found[1] ? 0 : gap + 1;
    summary.longest_gap = std::max(summary.longest_gap, gap);
    std::string line;
    append_seconds(line, film.t_ns());
    const int decimals = view ? 6 : 3;
    for (const MarkerPixel& pixel : found) {
      if (!pixel) {
        line += ",,";
        continue;
      }
      const cv::Point2d place = view   ? view->at(*pixel)
                                : lens ? lens->straightened(*pixel)
                                       : *pixel;
      line += ',' + fixed(place.x, decimals) + ',' + fixed(place.y, decimals);
    }
    track << line << '\n';
    progress.show(film.progress());
  }
  summary.frames = film.count();
  if (summary.frames == 0)
    throw std::invalid_argument(
        fmt::format("{}: contains no frame that can be read", options.film));
  for (const auto& [which, found] : {std::pair{"front", summary.front}, {"rear", summary.rear}})
    if (found == 0)
      throw std::invalid_argument(fmt::format(
          "{}: the {} marker is in none of its {}; check dictionary and identifier; a "
          "square of it should be 3 pixels at least, with a white rim around the marker",
          options.film, which, counted(static_cast<std::uint64_t>(summary.frames), "frame")));
  return summary;
}

}  // namespace odomd::tools
