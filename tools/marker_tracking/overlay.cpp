#include "tools/marker_tracking/overlay.hpp"

#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace odomd::tools {

cv::VideoWriter open_video(const std::filesystem::path& file, double rate, cv::Size picture) {
  cv::VideoWriter video(file.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate, picture);
  if (!video.isOpened())
    throw std::invalid_argument(file.string() + ": cannot be written as a video; name it .avi");
  video.set(cv::VIDEOWRITER_PROP_QUALITY, 90);
  return video;
}

void Overlay::add(cv::Mat picture, const std::array<MarkerPixel, 2>& found,
                  const std::string& time) {
  const std::array<cv::Scalar, 2> colours{cv::Scalar(0, 200, 0), cv::Scalar(0, 0, 220)};
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i]) tracks_[i].emplace_back(*found[i]);
    cv::polylines(picture, tracks_[i], false, colours[i], 1, cv::LINE_AA);
    if (found[i]) cv::circle(picture, tracks_[i].back(), 12, colours[i], 2, cv::LINE_AA);
  }
  cv::putText(picture, time, {10, picture.rows - 12}, cv::FONT_HERSHEY_SIMPLEX, 0.6,
              cv::Scalar(255, 255, 255), 1, cv::LINE_AA);
  video_.write(picture);
}

}  // namespace odomd::tools
