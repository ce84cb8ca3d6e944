// The figures that matter of several estimates of several drives: the paper's table.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "tools/cli/text.hpp"
#include "tools/evaluation/evaluated_drive.hpp"

namespace odomd::tools {

/// A row a drive and estimate; with several drives, a row an estimate with the means over the
/// drives behind them, of those estimates that all drives have. Columns that nobody has anything
/// for are left out, and so is the drive's where there is one.
[[nodiscard]] Table summary_table(std::span<const EvaluatedDrive> drives);

/// By source, how the samples were judged: a row a source that the drive has.
[[nodiscard]] Table source_table(const ReplaySummary& summary);

/// Everything, for programs.
[[nodiscard]] nlohmann::ordered_json summary_json(std::span<const EvaluatedDrive> drives);

}  // namespace odomd::tools
