
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tools/cli/output.hpp"
#include "tools/marker_tracking/film.hpp"

namespace odomd::tools {
namespace {

cv::Point2d mapped(const cv::Matx33d& h, const cv::Point2d& p) {
  const cv::Vec3d q = h * cv::Vec3d(p.x, p.y, 1.0);
  return {q[0] / q[2], q[1] / q[2]};
}

// The determinant of the map's Jacobian at a point: its sign shows whether the map mirrors.
double orientation(const cv::Matx33d& h, const cv::Point2d& p) {
  const double w = h(2, 0) * p.x + h(2, 1) * p.y + h(2, 2);
  return cv::determinant(h) / (w * w * w);
}

using Corners = std::vector<cv::Point2f>;

// Mean distance of the corners between two views / width of the picture.
double distance(const Corners& a, const Corners& b, int width) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += cv::norm(a[k] - b[k]);
  return sum / static_cast<double>(a.size()) / width;
}

}  // namespace

cv::Point2d Lens::straightened(const cv::Point2d& pixel) const {
  std::vector<cv::Point2d> in{pixel}, out;
  cv::undistortPoints(in, out, matrix, distortion, cv::noArray(), matrix);
  return out.front();
}

Lens read_lens(const std::filesystem::path& file) {
  const auto fail = [&file](const std::string& what) -> void {
    throw std::invalid_argument(
        fmt::format("{}: {}; calibrate with odom identify track --calibrate", file.string(), what));
  };
  if (!std::filesystem::is_regular_file(file)) fail("no such file");
  Lens lens;
  try {
    const cv::FileStorage storage(file.string(), cv::FileStorage::READ);
    cv::Mat matrix, distortion;
    storage["camera_matrix"] >> matrix;
    storage["distortion_coefficients"] >> distortion;
    if (matrix.rows != 3 || matrix.cols != 3) fail("has no 3 x 3 camera_matrix");
    matrix.convertTo(matrix, CV_64F);
    lens.matrix = cv::Matx33d(matrix.ptr<double>());
    distortion.convertTo(distortion, CV_64F);
    lens.distortion.assign(distortion.begin<double>(), distortion.end<double>());
    const std::size_t n = lens.distortion.size();
    if (n != 4 && n != 5 && n != 8 && n != 12 && n != 14)
      fail("has no distortion_coefficients (4, 5, 8, 12 or 14 numbers)");
    if (!cv::checkRange(distortion)) fail("has a coefficient that is not finite");
    if (!(lens.matrix(0, 0) > 0.0 && lens.matrix(1, 1) > 0.0 && cv::checkRange(lens.matrix)))
      fail("has a camera_matrix without focal lengths");
    if (!storage["image_width"].empty() && !storage["image_height"].empty())
      lens.picture = {static_cast<int>(storage["image_width"]),
                      static_cast<int>(storage["image_height"])};
  } catch (const cv::Exception&) {
    fail("is not YAML, XML or JSON as written by OpenCV");
  }
  return lens;
}

void write_lens(const std::filesystem::path& file, const Lens& lens) {
  cv::FileStorage storage;
  bool open = false;
  try {
    open = storage.open(file.string(), cv::FileStorage::WRITE);
  } catch (const cv::Exception&) {  // OpenCV does not know the ending
    throw std::invalid_argument(
        fmt::format("{}: a lens ends in .yaml, .yml, .xml or .json", file.string()));
  }
  if (!open) throw std::invalid_argument(fmt::format("{}: cannot be written", file.string()));
  storage << "image_width" << lens.picture.width << "image_height" << lens.picture.height;
  storage << "camera_matrix" << cv::Mat(lens.matrix);
  storage << "distortion_coefficients" << cv::Mat(lens.distortion).t();
  storage << "avg_reprojection_error" << lens.rms_px;
  storage.release();
}

std::vector<std::string> calibrate_lens(const TrackOptions& options) {
  constexpr std::size_t max_views = 40, min_views = 6;
  constexpr double another_view = 0.04;  // of the picture's width
  const BoardSize size = parse_board(options.calibrate);
  const cv::Size board(size.columns, size.rows);

  FilmReader film(options);
  std::vector<Corners> views;
  ProgressLine progress("odom identify track", WithoutTerminal::nothing);
  while (views.size() < max_views && film.next()) {
    progress.show(film.progress());
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
      return distance(view, corners, film.size().width) > another_view;
    });
    if (another) views.push_back(corners);
  }
  if (views.size() < min_views)
    throw std::invalid_argument(fmt::format(
        "{}: shows a chessboard of {} x {} inner corners in {} different places, and {} are "
        "needed; hold it nearer and farther, tilted, and into the corners of the picture",
        options.film, size.columns, size.rows, views.size(), min_views));

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
        "warning: more than a pixel: is the board flat, the focus fixed, the film sharp?");
  return notes;
}

GroundView::GroundView(std::span<const GroundPoint> points, const std::optional<Lens>& lens,
                       double height)
    : lens_(lens) {
  std::vector<cv::Point2d> pixels, places;
  std::vector<cv::Point3d> on_ground;
  for (const GroundPoint& point : points) {
    pixels.push_back(lens ? lens->straightened(point.pixel) : point.pixel);
    places.push_back(point.place);
    on_ground.emplace_back(point.place.x, point.place.y, 0.0);
  }
  const cv::Mat found = cv::findHomography(pixels, places, 0);
  if (found.empty())
    throw std::invalid_argument(
        fmt::format("--ground-marker: these places are impossible in one view; no three of them "
                    "may lie in a line"));
  to_plane_ = cv::Matx33d(found.ptr<double>());
  double squares = 0.0, size = 0.0;
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    squares += std::pow(cv::norm(mapped(to_plane_, pixels[k]) - places[k]), 2);
    size = std::max(size, cv::norm(places[k] - places[0]));
    // Seen from above, a correct map mirrors: v points down in the picture.
    if (orientation(to_plane_, pixels[k]) >= 0.0)
      throw std::invalid_argument(
          fmt::format("--ground-marker: the places are mirrored, or three of them lie in a line; "
                      "seen from above y "
                      "points to the left of x"));
  }
  misfit_ = std::sqrt(squares / static_cast<double>(pixels.size()));
  if (misfit_ > 0.1 * size)
    throw std::invalid_argument(
        fmt::format("--ground-marker: the places lie {:.3g} m from where the picture shows them; "
                    "are two exchanged?",
                    misfit_));
  if (!lens || height <= 0.0) return;

  // With the ground's pose [R|t] in the camera's frame, a point (X, Y, h) is seen at K (r₁ X + r₂ Y
  // + r₃ h + t): a homography from the plane at that height.
  cv::Mat rotation, translation, turn;
  cv::solvePnP(on_ground, pixels, lens->matrix, cv::noArray(), rotation, translation, false,
               cv::SOLVEPNP_IPPE);
  cv::solvePnPRefineLM(on_ground, pixels, lens->matrix, cv::noArray(), rotation, translation);
  cv::Rodrigues(rotation, turn);
  const cv::Matx33d r(turn.ptr<double>());
  const cv::Vec3d t(translation.ptr<double>());
  cv::Matx33d from_plane;
  for (int row = 0; row < 3; ++row) {
    from_plane(row, 0) = r(row, 0);
    from_plane(row, 1) = r(row, 1);
    from_plane(row, 2) = r(row, 2) * height + t[row];
  }
  to_plane_ = (lens->matrix * from_plane).inv();
}

cv::Point2d GroundView::at(const cv::Point2d& pixel) const {
  return mapped(to_plane_, lens_ ? lens_->straightened(pixel) : pixel);
}

}  // namespace odomd::tools
