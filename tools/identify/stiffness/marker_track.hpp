// Marker tracks of a film as tracking programs export them.
#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace odomd::tools {

/// A point or a direction in the plane, x + i y: products turn.
using Plane = std::complex<double>;

/// A frame in which both markers were found; places in the track's unit and axes.
struct MarkerFrame {
  std::int64_t t_ns = 0;
  Plane front, rear;
};

struct MarkerTrack {
  std::string name;                 ///< of the file, for messages
  std::vector<MarkerFrame> frames;  ///< times strictly increasing
  std::size_t gaps = 0;             ///< rows without both markers
};

/// How the first column counts time.
struct FilmTime {
  std::optional<double> frames_per_second;  ///< given: the column holds frame numbers
};

/// A file with the columns t, x_front, y_front, x_rear, y_rear, in any order; others are passed
/// over. Fields are parted by tabs, semicolons, commas or blanks; where commas do not part fields
/// they may be decimal ones. Lines before the first number are headings, the last of them names the
/// columns; "#" begins a comment. An empty field is a marker not seen. Throws std::invalid_argument
/// with file, line and column.
[[nodiscard]] MarkerTrack read_marker_track(const std::filesystem::path& file,
                                            const FilmTime& time = {});

/// A file a marker, each with t, x, y; without headings in this order. Only times that both have
/// count.
[[nodiscard]] MarkerTrack read_marker_tracks(const std::filesystem::path& front,
                                             const std::filesystem::path& rear,
                                             const FilmTime& time = {});

}  // namespace odomd::tools
