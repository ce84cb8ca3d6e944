// Converts pixels to positions, with the lens and the plane in which the markers move.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

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
