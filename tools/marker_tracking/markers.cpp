#include "tools/marker_tracking/markers.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tools/cli/csv.hpp"

namespace odomd::tools {
namespace {

struct Named {
  const char* name;
  cv::aruco::PREDEFINED_DICTIONARY_NAME dictionary;
};
constexpr std::array dictionaries{
    Named{"4x4_50", cv::aruco::DICT_4X4_50},
    Named{"4x4_100", cv::aruco::DICT_4X4_100},
    Named{"4x4_250", cv::aruco::DICT_4X4_250},
    Named{"4x4_1000", cv::aruco::DICT_4X4_1000},
    Named{"5x5_50", cv::aruco::DICT_5X5_50},
    Named{"5x5_100", cv::aruco::DICT_5X5_100},
    Named{"5x5_250", cv::aruco::DICT_5X5_250},
    Named{"5x5_1000", cv::aruco::DICT_5X5_1000},
    Named{"6x6_50", cv::aruco::DICT_6X6_50},
    Named{"6x6_100", cv::aruco::DICT_6X6_100},
    Named{"6x6_250", cv::aruco::DICT_6X6_250},
    Named{"6x6_1000", cv::aruco::DICT_6X6_1000},
    Named{"7x7_50", cv::aruco::DICT_7X7_50},
    Named{"7x7_100", cv::aruco::DICT_7X7_100},
    Named{"7x7_250", cv::aruco::DICT_7X7_250},
    Named{"7x7_1000", cv::aruco::DICT_7X7_1000},
    Named{"original", cv::aruco::DICT_ARUCO_ORIGINAL},
    Named{"apriltag_16h5", cv::aruco::DICT_APRILTAG_16h5},
    Named{"apriltag_25h9", cv::aruco::DICT_APRILTAG_25h9},
    Named{"apriltag_36h10", cv::aruco::DICT_APRILTAG_36h10},
    Named{"apriltag_36h11", cv::aruco::DICT_APRILTAG_36h11},
};

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const std::string& name) {
  std::string names;
  for (const Named& known : dictionaries) {
    if (name == known.name) return cv::aruco::getPredefinedDictionary(known.dictionary);
    names += (names.empty() ? "" : ", ") + std::string(known.name);
  }
  throw std::invalid_argument("--aruco: no dictionary " + tools::quoted(name) +
                              "; available: " + names);
}

// Where the diagonals cross: a + t (c - a) = b + u (d - b).
cv::Point2d crossing(const std::vector<cv::Point2f>& corners) {
  const cv::Point2d a = corners[0], b = corners[1], c = corners[2], d = corners[3];
  const cv::Point2d ac = c - a, bd = d - b;
  const double t = (b - a).cross(bd) / ac.cross(bd);
  return a + t * ac;
}

}  // namespace

struct ArucoFinder::Detector {
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
};

ArucoFinder::ArucoFinder(const std::string& dictionary)
    : detector_(std::make_unique<Detector>(Detector{dictionary_of(dictionary)})) {
  detector_->parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  detector_->parameters->cornerRefinementWinSize = 3;
  // Markers of cars are small in a picture of the whole circle.
  detector_->parameters->minMarkerPerimeterRate = 0.01;
}

ArucoFinder::~ArucoFinder() = default;

std::vector<MarkerPixel> ArucoFinder::find(const cv::Mat& picture,
                                           const std::vector<int>& identifiers) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> found;
  cv::aruco::detectMarkers(grey, detector_->dictionary, corners, found, detector_->parameters);
  std::vector<MarkerPixel> middles(identifiers.size());
  for (std::size_t k = 0; k < identifiers.size(); ++k) {
    if (std::ranges::count(found, identifiers[k]) != 1) continue;
    const auto at = std::ranges::find(found, identifiers[k]) - found.begin();
    middles[k] = crossing(corners[static_cast<std::size_t>(at)]);
  }
  return middles;
}

MarkerPixel ColourFinder::find(const cv::Mat& picture) {
  cv::Mat hsv;
  cv::cvtColor(picture, hsv, cv::COLOR_BGR2HSV_FULL);  // hue 0 to 255 for a turn
  const double turn = 256.0 / 360.0;
  const double low = turn * (colour_.hue - colour_.tolerance);
  const double high = turn * (colour_.hue + colour_.tolerance);
  cv::Mat mask;
  const auto in = [&](double from, double to, cv::Mat& result) {
    cv::inRange(hsv, cv::Scalar(from, 255.0 * colour_.saturation, 255.0 * colour_.brightness),
                cv::Scalar(to, 255.0, 255.0), result);
  };
  in(std::max(low, 0.0), std::min(high, 255.0), mask);
  if (low < 0.0 || high > 255.0) {  // red lies on both ends
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

}  // namespace odomd::tools
