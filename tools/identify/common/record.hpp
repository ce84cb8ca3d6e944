// The options for a gyro's record: a CAN log with its configuration, or a CSV of a phone or logger.
#pragma once

#include <string>
#include <vector>

#include "daemon/diagnostics/diagnostic.hpp"
#include "tools/cli/command.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

struct RecordOptions {
  std::string config;
  std::vector<std::string> logs;
  std::string csv;
  std::string from, to;
  can::Damage damage = can::Damage::left_out;
};

void add_record_options(Command method, RecordOptions& options);

[[nodiscard]] bool is_given(const RecordOptions& options);
[[nodiscard]] std::string name_of(const RecordOptions& options);

/// The signals between --from and --to; a CSV gives those of `columns` that it contains, and must
/// contain one. Throws std::invalid_argument for an unusable record.
[[nodiscard]] SignalLog read_record(const RecordOptions& options,
                                    const std::vector<estimator::Source>& columns);

/// The yaw rate of a record.
[[nodiscard]] Series read_yaw_rate(const RecordOptions& options,
                                   diagnostics::Diagnostics& warnings);

}  // namespace odomd::tools
