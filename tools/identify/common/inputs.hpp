// What the methods get on their command lines: measured numbers, and the record of a gyro.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/command.hpp"
#include "tools/identify/common/signal_log.hpp"

namespace odomd::tools {

// Measured numbers: "2985g", "265mm", "15deg". Without a unit they are in the SI unit.

enum class Dimension : std::uint8_t { mass, length, angle, time, pure };

/// `option` is the option's name in messages: "--front". Throws std::invalid_argument if the text
/// is not a finite number, or has a unit of another dimension.
[[nodiscard]] double parse_quantity(std::string_view text, Dimension dimension,
                                    std::string_view option);

/// Like parse_quantity(), for a number that must be positive, or not negative.
[[nodiscard]] double parse_positive(std::string_view text, Dimension dimension,
                                    std::string_view option);
[[nodiscard]] double parse_not_negative(std::string_view text, Dimension dimension,
                                        std::string_view option);
/// The number, or `otherwise` if the text is empty.
[[nodiscard]] double parse_or(double otherwise, std::string_view text, Dimension dimension,
                              std::string_view option);

/// The range of a quantity for any car, from a model to a lorry; outside it the unit must be wrong.
struct Plausible {
  double from = 0.0;
  double to = 0.0;
};
[[nodiscard]] double parse_plausible(std::string_view text, Dimension dimension,
                                     std::string_view option, Plausible range);

/// --measured, for the methods that use scale, tape and stop-watch. Add it before other options.
void add_measured_option(Command method);

// A gyro's record: a CAN log with its configuration, or a CSV of a phone or logger.

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
