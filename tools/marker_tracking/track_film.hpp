// Tracks the markers of a car through a film.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "tools/marker_tracking/options.hpp"

namespace odomd::tools {

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
