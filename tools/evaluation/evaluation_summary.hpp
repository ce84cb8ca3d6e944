// The main figures of several estimates on several drives: the paper's table.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "tools/cli/text.hpp"
#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools {

/// One row per drive and estimate; with several drives, followed by one row with the means for each
/// estimate that all drives have. Empty columns are left out, and so is the drive's if there is
/// only one.
[[nodiscard]] Table summary_table(std::span<const EvaluatedDrive> drives);

/// The judgements of the samples: one row per source of the drive.
[[nodiscard]] Table source_table(const ReplaySummary& summary);

/// Everything as JSON.
[[nodiscard]] nlohmann::ordered_json summary_json(std::span<const EvaluatedDrive> drives);

}  // namespace odomd::tools
