// The result of a replay as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/replay/virtual_drive.hpp"

namespace odomd::tools {

/// Counts, times, by source how its samples were judged, and what there is to warn of. `seconds`:
/// how long the replay took.
[[nodiscard]] nlohmann::ordered_json replay_json(const ReplaySummary& summary, double seconds,
                                                 const diagnostics::Diagnostics& warnings);

/// The innovations by source, for sources with tested samples.
[[nodiscard]] nlohmann::ordered_json innovations_json(const ReplaySummary& summary);

/// By source, the stated sigma and the filter's estimates at the end (null: none); of those sources
/// that have one.
[[nodiscard]] nlohmann::ordered_json noise_json(const ReplaySummary& summary);

/// By source, how many samples had which verdict; those that came.
[[nodiscard]] nlohmann::ordered_json verdicts_json(const ReplaySummary& summary);

}  // namespace odomd::tools
