// The result of a replay as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Counts, times, how the samples of each source were judged, and warnings. `seconds`: how long the
/// replay took.
[[nodiscard]] nlohmann::ordered_json replay_json(const ReplaySummary& summary, double seconds,
                                                 const diagnostics::Diagnostics& warnings);

/// The innovations per source, for sources with tested samples.
[[nodiscard]] nlohmann::ordered_json innovations_json(const ReplaySummary& summary);

/// The stated sigma and the filter's estimates at the end (null: none), for each source that has an
/// estimate.
[[nodiscard]] nlohmann::ordered_json noise_json(const ReplaySummary& summary);

/// The number of samples per source and verdict; zeros are left out.
[[nodiscard]] nlohmann::ordered_json verdicts_json(const ReplaySummary& summary);

}  // namespace odomd::tools
