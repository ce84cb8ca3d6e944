#include "tools/marker_tracking/markers.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string_view>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

// In the order of OpenCV's enumeration.
constexpr std::array<std::string_view, 21> dictionaries{
    "4x4_50",        "4x4_100",        "4x4_250",       "4x4_1000", "5x5_50",   "5x5_100",
    "5x5_250",       "5x5_1000",       "6x6_50",        "6x6_100",  "6x6_250",  "6x6_1000",
    "7x7_50",        "7x7_100",        "7x7_250",       "7x7_1000", "original", "apriltag_16h5",
    "apriltag_25h9", "apriltag_36h10", "apriltag_36h11"};
static_assert(cv::aruco::DICT_APRILTAG_36h11 == dictionaries.size() - 1);

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const std::string& name) {
  const auto* const found = std::ranges::find(dictionaries, name);
  if (found == dictionaries.end())
    throw std::invalid_argument(fmt::format("--aruco: no dictionary {}; available: {}",
                                            tools::quoted(name), fmt::join(dictionaries, ", ")));
  return cv::aruco::getPredefinedDictionary(static_cast<int>(found - dictionaries.begin()));
}

// The intersection of the diagonals: a + t (c - a) = b + u (d - b).
cv::Point2d crossing(const std::vector<cv::Point2f>& corners) {
  const cv::Point2d a = corners[0], b = corners[1], c = corners[2], d = corners[3];
  const cv::Point2d ac = c - a, bd = d - b;
  const double t = (b - a).cross(bd) / ac.cross(bd);
  return a + t * ac;
}

/// Finds the largest spot of a colour. If others are nearly as large, takes the one nearest to the
/// last position found.
class ColourFinder {
 public:
  explicit ColourFinder(const ColourRange& colour) : colour_(colour) {}

  MarkerPixel find(const cv::Mat& picture) {
    cv::Mat hsv;
    cv::cvtColor(picture, hsv, cv::COLOR_BGR2HSV_FULL);  // 256 hues for a full turn
    const double turn = 256.0 / 360.0;
    const double low = turn * (colour_.hue - colour_.tolerance);
    const double high = turn * (colour_.hue + colour_.tolerance);
    cv::Mat mask;
    const auto in = [&](double from, double to, cv::Mat& result) {
      cv::inRange(hsv, cv::Scalar(from, 255.0 * colour_.saturation, 255.0 * colour_.brightness),
                  cv::Scalar(to, 255.0, 255.0), result);
    };
    in(std::max(low, 0.0), std::min(high, 255.0), mask);
    if (low < 0.0 || high > 255.0) {  // red is at both ends of the range
      cv::Mat other;
      in(low < 0.0 ? low + 256.0 : 0.0, low < 0.0 ? 255.0 : high - 256.0, other);
      mask |= other;
    }
    cv::Mat labels, statistics, middles;
    const int count = cv::connectedComponentsWithStats(mask, labels, statistics, middles, 8);

    constexpr int smallest = 9;  // pixels
    int largest = 0;
    for (int k = 1; k < count; ++k)
      largest = std::max(largest, statistics.at<int>(k, cv::CC_STAT_AREA));
    if (largest < smallest) return std::nullopt;
    std::vector<cv::Point2d> candidates;
    for (int k = 1; k < count; ++k)
      if (10 * statistics.at<int>(k, cv::CC_STAT_AREA) >= 6 * largest)
        candidates.emplace_back(middles.at<double>(k, 0), middles.at<double>(k, 1));
    if (candidates.size() > 1) {
      if (!last_) return std::nullopt;
      std::ranges::sort(candidates, {},
                        [this](const cv::Point2d& p) { return cv::norm(p - *last_); });
    }
    last_ = candidates.front();
    return last_;
  }

 private:
  ColourRange colour_;
  MarkerPixel last_;
};

}  // namespace

FindMarkers aruco_finder(const std::string& dictionary, const std::vector<int>& identifiers) {
  const cv::Ptr<cv::aruco::Dictionary> markers = dictionary_of(dictionary);
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  parameters->cornerRefinementWinSize = 3;
  // Markers on cars are small if the picture shows a whole circle.
  parameters->minMarkerPerimeterRate = 0.01;
  return [markers, parameters, identifiers](const cv::Mat& picture) {
    cv::Mat grey;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> found;
    cv::aruco::detectMarkers(grey, markers, corners, found, parameters);
    std::vector<MarkerPixel> middles(identifiers.size());
    for (std::size_t k = 0; k < identifiers.size(); ++k) {
      if (std::ranges::count(found, identifiers[k]) != 1) continue;
      const auto at = std::ranges::find(found, identifiers[k]) - found.begin();
      middles[k] = crossing(corners[static_cast<std::size_t>(at)]);
    }
    return middles;
  };
}

FindMarkers colour_finder(const std::vector<ColourRange>& colours) {
  std::vector<ColourFinder> finders(colours.begin(), colours.end());
  return [finders](const cv::Mat& picture) mutable {
    std::vector<MarkerPixel> middles;
    for (ColourFinder& finder : finders) middles.push_back(finder.find(picture));
    return middles;
  };
}

}  // namespace odomd::tools
