// The main figures of several estimates on several drives: the paper's table.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "tools/cli/text.hpp"
#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools {

/// One row per drive and estimate. If several drives have the same estimates, one row per estimate
/// with the means follows. Leaves out empty columns, and drive names if there is one drive.
[[nodiscard]] Table summary_table(std::span<const EvaluatedDrive> drives);

/// The definition of the metric with this label or this header; empty for other words.
[[nodiscard]] std::string_view definition_of(std::string_view label);

/// Verdicts on the samples and their innovations: one row per source of the drive.
[[nodiscard]] Table source_table(const ReplaySummary& summary);

/// Everything as JSON.
[[nodiscard]] nlohmann::ordered_json summary_json(std::span<const EvaluatedDrive> drives);

}  // namespace odomd::tools
