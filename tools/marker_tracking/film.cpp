#include "tools/marker_tracking/film.hpp"

#include <cmath>
#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"

namespace odomd::tools {
namespace {

std::vector<std::int64_t> read_times(const std::string& file) {
  auto input = open_input(file);
  CsvReader reader(input, file, {"t"});
  std::vector<std::int64_t> times;
  while (reader.next()) {
    const std::int64_t time = reader.time_ns(0);
    if (!times.empty() && time <= times.back())
      reader.fail(0, "is not later than the row before; the frames of a film must be in order");
    times.push_back(time);
  }
  return times;
}

}  // namespace

FilmReader::FilmReader(const TrackOptions& options)
    : name_(options.film), frames_per_second_(options.frames_per_second) {
  static_cast<void>(open_input(name_));  // says what is wrong with the file, which OpenCV does not
  if (!options.frame_times.empty()) {
    times_name_ = options.frame_times;
    times_ns_ = read_times(times_name_);
  }
  // Not every backend that OpenCV has: some go on to look for cameras on USB.
  if (!capture_.open(name_, cv::CAP_FFMPEG) && !capture_.open(name_, cv::CAP_OPENCV_MJPEG))
    throw std::invalid_argument(name_ +
                                ": cannot be read as a film; convert it to MP4 or AVI: "
                                "ffmpeg -i FILM film.mp4");
  size_ = {static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_WIDTH)),
           static_cast<int>(capture_.get(cv::CAP_PROP_FRAME_HEIGHT))};
  const double frames = capture_.get(cv::CAP_PROP_FRAME_COUNT);
  total_ = frames > 0.0 && frames < 1e9 ? static_cast<std::int64_t>(frames) : 0;
}

bool FilmReader::next() {
  if (!capture_.read(picture_) || picture_.empty()) return false;
  size_ = picture_.size();
  const std::int64_t time = time_of_frame();
  if (count_ > 0 && time <= t_ns_)
    throw std::invalid_argument(
        fmt::format("{}: the times of its frames do not increase at frame {}; give them with --fps "
                    "or --frame-times",
                    name_, count_));
  t_ns_ = time;
  ++count_;
  return true;
}

std::int64_t FilmReader::time_of_frame() {
  if (!times_name_.empty()) {
    if (static_cast<std::size_t>(count_) >= times_ns_.size())
      throw std::invalid_argument(
          fmt::format("{}: has {} times, and the film more frames; give one "
                      "for each",
                      times_name_, times_ns_.size()));
    return times_ns_[static_cast<std::size_t>(count_)];
  }
  if (frames_per_second_)
    return std::llround(1e9 * static_cast<double>(count_) / *frames_per_second_);
  return std::llround(1e6 * capture_.get(cv::CAP_PROP_POS_MSEC));
}

}  // namespace odomd::tools
