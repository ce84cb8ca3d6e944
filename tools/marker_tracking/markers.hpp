// Markers in a picture, to a part of a pixel.
#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

using MarkerPixel = std::optional<cv::Point2d>;

/// ArUco markers; the middle is where the diagonals cross, which perspective leaves alone.
class ArucoFinder {
 public:
  /// Throws std::invalid_argument for a name that is no dictionary's, with those there are.
  explicit ArucoFinder(const std::string& dictionary);
  ~ArucoFinder();
  ArucoFinder(const ArucoFinder&) = delete;
  ArucoFinder& operator=(const ArucoFinder&) = delete;

  /// The middles of these identifiers; nothing for one that is not there, or twice.
  [[nodiscard]] std::vector<MarkerPixel> find(const cv::Mat& picture,
                                              const std::vector<int>& identifiers);

 private:
  struct Detector;
  std::unique_ptr<Detector> detector_;
};

/// The largest spot of a colour, if no other is nearly as large; else the one nearest to its place
/// in the frame before.
class ColourFinder {
 public:
  explicit ColourFinder(const ColourRange& colour) : colour_(colour) {}

  [[nodiscard]] MarkerPixel find(const cv::Mat& picture);

 private:
  ColourRange colour_;
  MarkerPixel last_;
};

}  // namespace odomd::tools
