// A video of a film with what was found in it.
#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "tools/marker_tracking/markers.hpp"

namespace odomd::tools {

/// A video that is written frame by frame. Throws std::invalid_argument if it cannot be.
[[nodiscard]] cv::VideoWriter open_video(const std::filesystem::path& file, double rate,
                                         cv::Size picture);

class Overlay {
 public:
  Overlay(const std::filesystem::path& file, double rate, cv::Size picture)
      : video_(open_video(file, rate, picture)) {}

  /// Adds a frame: both markers in a ring, front green and rear red, and their tracks so far.
  void add(cv::Mat picture, const std::array<MarkerPixel, 2>& found, const std::string& time);

 private:
  cv::VideoWriter video_;
  std::array<std::vector<cv::Point>, 2> tracks_;
};

}  // namespace odomd::tools
