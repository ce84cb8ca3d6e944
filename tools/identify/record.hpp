// The options by which a method is given a gyro's record: a CAN log with its configuration, or a
// CSV of a phone or logger.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "tools/identify/signal_log.hpp"

namespace odomd::tools {

struct RecordOptions {
  std::string config;
  std::vector<std::string> logs;
  std::string csv;
  std::string from, to;
};

void add_record_options(CLI::App& method, RecordOptions& options, const std::string& group);

[[nodiscard]] bool is_given(const RecordOptions& options);
[[nodiscard]] std::string name_of(const RecordOptions& options);

/// The yaw rate between --from and --to. Throws std::invalid_argument for what cannot be used.
[[nodiscard]] Series read_yaw_rate(const RecordOptions& options,
                                   std::vector<std::string>& warnings);

/// Reads t [s] and one column of a CSV; the times must rise.
[[nodiscard]] Series read_csv_series(const std::string& file, const std::string& column,
                                     std::vector<std::string>& warnings);

}  // namespace odomd::tools
