// The data of a plot: the poses of a file or of a running daemon over time, with some further
// columns.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/drive_files/beat_histogram.hpp"
#include "tools/drive_files/trajectory.hpp"

namespace odomd::tools {

struct Track {
  Trajectory trajectory;
  std::vector<std::vector<double>> columns;  ///< as were asked for, a value a row of the file;
                                             ///< empty: the file has it not
  std::vector<std::int64_t> times_ns;        ///< of these rows
};

/// Reads a pose file, and of the further columns those that it has. Throws std::invalid_argument
/// with file, line and column where it is not usable.
[[nodiscard]] Track read_track(const std::filesystem::path& file, Frame frame,
                               const std::vector<std::string>& further);

struct LiveTrack {
  Track track;
  BeatHistogram beat;
};

/// Follows a running daemon for so long, or until INT: the columns are those of a pose file. Throws
/// as attach() does, and std::runtime_error where no pose came.
[[nodiscard]] LiveTrack follow_daemon(const std::string& shm, double seconds, Frame frame,
                                      const std::vector<std::string>& further);

}  // namespace odomd::tools
