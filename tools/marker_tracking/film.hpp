// Reads a film frame by frame, each with its time, and writes videos of what was found in it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/marker_tracking/markers.hpp"
#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

class FilmReader {
 public:
  /// Throws std::invalid_argument if the file is no film, or the options' times cannot be read.
  explicit FilmReader(const TrackOptions& options);

  /// Reads the next frame; returns false at the end. Throws std::invalid_argument if the film's
  /// times do not increase, or --frame-times has too few rows.
  [[nodiscard]] bool next();

  [[nodiscard]] const cv::Mat& picture() const { return picture_; }
  [[nodiscard]] std::int64_t t_ns() const { return t_ns_; }
  [[nodiscard]] std::int64_t count() const { return count_; }  ///< frames read so far
  [[nodiscard]] std::int64_t total() const { return total_; }  ///< from the container; 0: unknown
  [[nodiscard]] cv::Size size() const { return size_; }
  [[nodiscard]] double rate() const { return capture_.get(cv::CAP_PROP_FPS); }  ///< [1/s]

 private:
  [[nodiscard]] std::int64_t time_of_frame();

  std::string name_;
  cv::VideoCapture capture_;
  std::optional<double> frames_per_second_;
  std::string times_name_;
  std::vector<std::int64_t> times_ns_;
  cv::Mat picture_;
  cv::Size size_;
  std::int64_t t_ns_ = 0;
  std::int64_t count_ = 0;
  std::int64_t total_ = 0;
};

/// Opens a video for writing frame by frame. Throws std::invalid_argument if that fails.
[[nodiscard]] cv::VideoWriter open_video(const std::filesystem::path& file, double rate,
                                         cv::Size picture);

/// A video of the film with the markers that were found.
class Overlay {
 public:
  Overlay(const std::filesystem::path& file, double rate, cv::Size picture)
      : video_(open_video(file, rate, picture)) {}

  /// Adds a frame with both markers in a ring, front green and rear red, and their tracks so far.
  void add(cv::Mat picture, const std::vector<MarkerPixel>& found, const std::string& time);

 private:
  cv::VideoWriter video_;
  std::array<std::vector<cv::Point>, 2> tracks_;
};

/// Shows the progress on a terminal.
class FrameProgress {
 public:
  explicit FrameProgress(bool always);
  ~FrameProgress();
  FrameProgress(const FrameProgress&) = delete;
  FrameProgress& operator=(const FrameProgress&) = delete;

  void update(std::int64_t frame, std::int64_t total, std::int64_t found);

 private:
  bool shown_;
  bool drawn_ = false;
};

}  // namespace odomd::tools
