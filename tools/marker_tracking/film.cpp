#include "tools/marker_tracking/film.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tools/cli/csv.hpp"
#include "tools/cli/files.hpp"
#include "tools/cli/output.hpp"

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
  static_cast<void>(open_input(name_));  // unlike OpenCV, it reports what is wrong with the file
  if (!options.frame_times.empty()) {
    times_name_ = options.frame_times;
    times_ns_ = read_times(times_name_);
  }
  // Only these two of OpenCV's backends: some others search for USB cameras.
  if (!capture_.open(name_, cv::CAP_FFMPEG) && !capture_.open(name_, cv::CAP_OPENCV_MJPEG))
    throw std::invalid_argument(fmt::format(
        "{}: cannot be read as a film; convert it to MP4 or AVI: ffmpeg -i FILM film.mp4", name_));
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

cv::VideoWriter open_video(const std::filesystem::path& file, double rate, cv::Size picture) {
  cv::VideoWriter video(file.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate, picture);
  if (!video.isOpened())
    throw std::invalid_argument(
        fmt::format("{}: cannot be written as a video; name it .avi", file.string()));
  video.set(cv::VIDEOWRITER_PROP_QUALITY, 90);
  return video;
}

void Overlay::add(cv::Mat picture, const std::vector<MarkerPixel>& found, const std::string& time) {
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

FrameProgress::FrameProgress(bool always) : shown_(always || ::isatty(STDERR_FILENO) != 0) {}

FrameProgress::~FrameProgress() {
  if (drawn_) draw("\n");
}

void FrameProgress::update(std::int64_t frame, std::int64_t total, std::int64_t found) {
  if (!shown_ || (frame % 25 != 0 && frame != total)) return;
  drawn_ = true;
  const std::string of = total > 0 ? fmt::format(" of {}", total) : "";
  draw(fmt::format("\rframe {}{}, both markers in {}   ", frame, of, found));
}

}  // namespace odomd::tools
