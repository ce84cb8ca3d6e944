// Finds markers in a picture with subpixel accuracy.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

using MarkerPixel = std::optional<cv::Point2d>;

/// Returns the middle of each marker in a picture; nothing for a marker that is not found.
using FindMarkers = std::function<std::vector<MarkerPixel>(const cv::Mat&)>;

/// Finds ArUco markers that each appear exactly once in the picture; the middle is where the
/// diagonals cross, also in perspective. Throws std::invalid_argument for an unknown dictionary,
/// with the available ones.
[[nodiscard]] FindMarkers aruco_finder(const std::string& dictionary,
                                       const std::vector<int>& identifiers);

/// Finds spots of these colours, and follows them from picture to picture.
[[nodiscard]] FindMarkers colour_finder(const std::vector<ColourRange>& colours);

}  // namespace odomd::tools
