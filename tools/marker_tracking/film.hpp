// Reads a film frame by frame, each with its time, and tracks the markers of a car through it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

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

struct TrackSummary {
  std::int64_t frames = 0;
  std::int64_t front = 0, rear = 0;  ///< frames in which the marker was found
  std::int64_t longest_gap = 0;      ///< most successive frames that lack a marker
  std::vector<std::string> notes;    ///< for people, one line each
};

/// Writes the track as CSV. Throws std::invalid_argument for unusable input, also for a film in
/// which a marker is never found.
[[nodiscard]] TrackSummary track_film(const TrackOptions& options, std::ostream& track);

}  // namespace odomd::tools
