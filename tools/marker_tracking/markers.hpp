// Markers in a picture, to a part of a pixel.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

using MarkerPixel = std::optional<cv::Point2d>;

/// The middle of each marker in a picture; nothing for one that is not there.
using FindMarkers = std::function<std::vector<MarkerPixel>(const cv::Mat&)>;

/// ArUco markers, each but once in a picture; the middle is where the diagonals cross, which
/// perspective leaves alone. Throws std::invalid_argument for a name that is no dictionary's, with
/// those there are.
[[nodiscard]] FindMarkers aruco_finder(const std::string& dictionary,
                                       const std::vector<int>& identifiers);

/// Spots of these colours, followed from picture to picture.
[[nodiscard]] FindMarkers colour_finder(const std::vector<ColourRange>& colours);

}  // namespace odomd::tools
