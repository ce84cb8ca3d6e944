// The options for a gyro's record: a CAN log with its configuration, or a CSV of a phone or logger.
#pragma once

#include <string>
#include <vector>

#include "tools/cli/command.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

struct RecordOptions {
  std::string config;
  std::vector<std::string> logs;
  std::string csv;
  std::string from, to;
  can::Damage damage = can::Damage::left_out;

  [[nodiscard]] bool is_given() const { return !csv.empty() || !logs.empty(); }
  [[nodiscard]] std::string name() const { return csv.empty() ? logs.front() : csv; }
};

void add_record_options(Command method, RecordOptions& options);

/// The signals between --from and --to; a CSV gives those of `columns` that it contains, and must
/// contain one. Throws std::invalid_argument for an unusable record.
[[nodiscard]] SignalLog read_record(const RecordOptions& options,
                                    const std::vector<estimator::Source>& columns);

}  // namespace odomd::tools
