// Reads a film frame by frame, each with its time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <string>

#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

class FilmReader {
 public:
  /// Throws std::invalid_argument if the file is no film.
  explicit FilmReader(const TrackOptions& options);

  /// Reads the next frame; returns false at the end. Throws std::invalid_argument if the film's
  /// times do not increase.
  [[nodiscard]] bool next();

  [[nodiscard]] const cv::Mat& picture() const { return picture_; }
  [[nodiscard]] std::int64_t t_ns() const { return t_ns_; }
  [[nodiscard]] std::int64_t count() const { return count_; }  ///< frames read so far
  [[nodiscard]] cv::Size size() const { return size_; }
  [[nodiscard]] double rate() const { return capture_.get(cv::CAP_PROP_FPS); }  ///< [1/s]
  /// "frame 25 of 40", or without the total if the container does not state it.
  [[nodiscard]] std::string progress() const;

 private:
  std::string name_;
  cv::VideoCapture capture_;
  std::optional<double> frames_per_second_;
  cv::Mat picture_;
  cv::Size size_;
  std::int64_t t_ns_ = 0;
  std::int64_t count_ = 0;
};

/// Opens a video for writing frame by frame. Throws std::invalid_argument if that fails.
[[nodiscard]] cv::VideoWriter open_video(const std::filesystem::path& file, double rate,
                                         cv::Size picture);

}  // namespace odomd::tools
