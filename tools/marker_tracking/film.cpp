#include "tools/marker_tracking/film.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "tools/cli/files.hpp"

namespace odomd::tools {

FilmReader::FilmReader(const TrackOptions& options)
    : name_(options.film), frames_per_second_(options.frames_per_second) {
  static_cast<void>(open_input(name_));  // unlike OpenCV, it reports what is wrong with the file
  // Only these two of OpenCV's backends: some others search for USB cameras.
  if (!capture_.open(name_, cv::CAP_FFMPEG) && !capture_.open(name_, cv::CAP_OPENCV_MJPEG))
    throw std::invalid_argument(fmt::format(
        "{}: cannot be read as a film; convert it to MP4 or AVI: ffmpeg -i FILM film.mp4", name_));
  size_ = {static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
           static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT))};
}

bool FilmReader::next() {
  if (!capture_.read(picture_) || picture_.empty()) return false;
  size_ = picture_.size();
  const std::int64_t time =
      frames_per_second_ ? std::llround(1e9 * static_cast<double>(count_) / *frames_per_second_)
                         : std::llround(1e6 * capture_.get(cv::CAP_PROP_POS_MSEC));
  if (count_ > 0 && time <= t_ns_)
    throw std::invalid_argument(fmt::format(
        "{}: the times of its frames do not increase at frame {}; give their rate with --fps",
        name_, count_));
  t_ns_ = time;
  ++count_;
  return true;
}

std::string FilmReader::progress() const {
  const double total = capture_.get(cv::CAP_PROP_FRAME_COUNT);
  return fmt::format("frame {}{}", count_,
                     total > 0.0 && total < 1e9 ? fmt::format(" of {:.0f}", total) : "");
}

cv::VideoWriter open_video(const std::filesystem::path& file, double rate, cv::Size picture) {
  cv::VideoWriter video(file.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate, picture);
  if (!video.isOpened())
    throw std::invalid_argument(
        fmt::format("{}: cannot be written as a video; name it .avi", file.string()));
  video.set(cv::VIDEOWRITER_PROP_QUALITY, 90);
  return video;
}

}  // namespace odomd::tools
