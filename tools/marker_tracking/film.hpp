// Reads a film frame by frame, each with its time, tracks the markers of a car through it, and
// converts pixels to positions, with the lens and the plane in which the markers move.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

class FilmReader {
 public:
  /// Throws std::invalid_argument if the file is no film.
  explicit FilmReader(const TrackOptions& options);

  /// Reads the next frame; returns false at the end. Throws std::invalid_argument if the film's
  /// times do not increase.
  [[nodiscard]] bool next();

  [[nodiscard]] const cv::Mat& picture() const { return picture_; }
  [[nodiscard]] std::int64_t t_ns() const { return t_ns_; }
  [[nodiscard]] std::int64_t count() const { return count_; }  ///< frames read so far
  [[nodiscard]] cv::Size size() const { return size_; }
  [[nodiscard]] double rate() const { return capture_.get(cv::CAP_PROP_FPS); }  ///< [1/s]
  /// "frame 25 of 40", or without the total if the container does not state it.
  [[nodiscard]] std::string progress() const;

 private:
  std::string name_;
  cv::VideoCapture capture_;
  std::optional<double> frames_per_second_;
  cv::Mat picture_;
  cv::Size size_;
  std::int64_t t_ns_ = 0;
  std::int64_t count_ = 0;
};

/// Opens a video for writing frame by frame. Throws std::invalid_argument if that fails.
[[nodiscard]] cv::VideoWriter open_video(const std::filesystem::path& file, double rate,
                                         cv::Size picture);

struct TrackSummary {
  std::int64_t frames = 0;
  std::int64_t front = 0, rear = 0;  ///< frames in which the marker was found
  std::int64_t longest_gap = 0;      ///< most successive frames that lack a marker
  std::vector<std::string> notes;    ///< for people, one line each
};

/// Writes the track as CSV. Throws std::invalid_argument for unusable input, also for a film in
/// which a marker is never found.
[[nodiscard]] TrackSummary track_film(const TrackOptions& options, std::ostream& track);

/// A pinhole camera with OpenCV's distortion.
struct Lens {
  cv::Matx33d matrix = cv::Matx33d::eye();
  std::vector<double> distortion;
  cv::Size picture;     ///< 0 x 0: not in the file
  double rms_px = 0.0;  ///< reprojection error of the calibration

  /// The position of the pixel without distortion.
  [[nodiscard]] cv::Point2d straightened(const cv::Point2d& pixel) const;
};

/// Reads camera_matrix and distortion_coefficients. Throws std::invalid_argument.
[[nodiscard]] Lens read_lens(const std::filesystem::path& file);
void write_lens(const std::filesystem::path& file, const Lens& lens);

/// Calibrates a lens from a film of a chessboard with OpenCV (Z. Zhang, A flexible new technique
/// for camera calibration, 2000) and writes it to options.out. Returns notes for the user.
[[nodiscard]] std::vector<std::string> calibrate_lens(const TrackOptions& options);

/// A point on the ground and the pixel that shows it.
struct GroundPoint {
  cv::Point2d pixel;
  cv::Point2d place;  ///< [m]
};

/// Maps pixels to metres on the plane of the markers.
class GroundView {
 public:
  /// Fits the view to four or more points with pixels and positions on the ground. `height` of the
  /// markers above the ground has no effect without a lens. Throws std::invalid_argument if the
  /// points do not fit the picture (they are in a line, or mirrored).
  GroundView(std::span<const GroundPoint> points, const std::optional<Lens>& lens, double height);

  [[nodiscard]] cv::Point2d at(const cv::Point2d& pixel) const;

  /// Distance between the given positions and those from the picture, rms [m].
  [[nodiscard]] double misfit() const { return misfit_; }

 private:
  std::optional<Lens> lens_;
  cv::Matx33d to_plane_;  ///< homography from undistorted pixels
  double misfit_ = 0.0;
};

}  // namespace odomd::tools
