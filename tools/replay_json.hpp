// What a replay has to say, for programs.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/virtual_drive.hpp"

namespace odomd::tools {

/// Counts, times, and by source how its samples lay to what the filter expected of them.
/// `seconds`: how long the replay took.
[[nodiscard]] nlohmann::ordered_json replay_json(const ReplaySummary& summary, double seconds);

}  // namespace odomd::tools
