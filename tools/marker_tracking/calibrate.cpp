// A lens from a film of a chessboard (Z. Zhang, A flexible new technique for camera calibration,
// 2000, as OpenCV does it).
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include <fmt/format.h>

#include "tools/marker_tracking/film.hpp"
#include "tools/marker_tracking/progress.hpp"
#include "tools/marker_tracking/track_film.hpp"
#include "tools/marker_tracking/view.hpp"

namespace odomd::tools {
namespace {

using Corners = std::vector<cv::Point2f>;

// Mean way of the corners between two views, over the width of the picture.
double moved(const Corners& a, const Corners& b, int width) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += cv::norm(a[k] - b[k]);
  return sum / static_cast<double>(a.size()) / width;
}

}  // namespace

std::vector<std::string> calibrate_lens(const TrackOptions& options) {
  constexpr std::size_t most_views = 40, least_views = 6;
  constexpr double another_view = 0.04;  // of the picture's width
  const BoardSize size = parse_board(options.calibrate);
  const cv::Size board(size.columns, size.rows);

  FilmReader film(options);
  std::vector<Corners> views;
  FrameProgress progress(options.progress);
  while (views.size() < most_views && film.next()) {
    progress.update(film.count(), film.total(), static_cast<std::int64_t>(views.size()));
    if (film.count() % 3 != 1) continue;
    cv::Mat grey;
    cv::cvtColor(film.picture(), grey, cv::COLOR_BGR2GRAY);
    Corners corners;
    if (!cv::findChessboardCorners(
            grey, board, corners,
            cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK))
      continue;
    cv::cornerSubPix(grey, corners, {5, 5}, {-1, -1},
                     {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01});
    const bool another = std::ranges::all_of(views, [&](const Corners& view) {
      return moved(view, corners, film.size().width) > another_view;
    });
    if (another) views.push_back(corners);
  }
  if (views.size() < least_views)
    throw std::invalid_argument(fmt::format(
        "{}: shows a chessboard of {} x {} inner corners in {} different places, and {} are "
        "needed; hold it nearer and farther, tilted, and into the corners of the picture",
        options.film, size.columns, size.rows, views.size(), least_views));

  std::vector<cv::Point3f> places;
  for (int row = 0; row < size.rows; ++row)
    for (int column = 0; column < size.columns; ++column)
      places.emplace_back(static_cast<float>(options.square * column),
                          static_cast<float>(options.square * row), 0.0F);
  const std::vector<std::vector<cv::Point3f>> boards(views.size(), places);
  cv::Mat matrix, distortion;
  std::vector<cv::Mat> rotations, translations;
  Lens lens;
  lens.rms_px =
      cv::calibrateCamera(boards, views, film.size(), matrix, distortion, rotations, translations);
  lens.matrix = cv::Matx33d(matrix.ptr<double>());
  lens.distortion.assign(distortion.begin<double>(), distortion.end<double>());
  lens.picture = film.size();
  write_lens(options.out, lens);

  std::vector<std::string> notes{
      fmt::format("{}: {} views, {:.2f} px rms", options.out, views.size(), lens.rms_px)};
  if (lens.rms_px > 1.0)
    notes.emplace_back(
        "warning: more than a pixel: is the board flat, the focus fixed, the film "
        "sharp?");
  return notes;
}

}  // namespace odomd::tools
