// Reads the times of tables: in s, ms, us or ns, in two columns (seconds and nanoseconds), or as
// times of day.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/csv.hpp"

namespace odomd::tools {

enum class TimeUnit : std::uint8_t { unstated, s, ms, us, ns, hhmmss };

struct TimeColumn {
  std::vector<std::string> columns;  ///< one, or two: seconds and nanoseconds
  TimeUnit unit = TimeUnit::unstated;
};

/// "s", "ms", "us", "ns" and "hhmmss"; anything else: unstated.
[[nodiscard]] TimeUnit time_unit(std::string_view text);

/// "speed" and "km/h" of "speed (km/h)"; the mark of a comment before the name is left out.
struct NameAndUnit {
  std::string_view name, unit;
};
[[nodiscard]] NameAndUnit split_unit(std::string_view column);

/// Whether the cell is "", "nan", "n/a", ...
[[nodiscard]] bool is_missing(std::string_view cell);

/// The time column if it has a name that tools usually give it; the sensor's own stamp is preferred
/// to the recorder's.
[[nodiscard]] std::optional<TimeColumn> usual_time(const std::vector<std::string>& columns);

/// Sets an unstated unit to the one in the header, below it, or in a name like "time_ms".
void take_unit(TimeColumn& time, std::string_view unit_of_table);

/// The time in the reader's current row; empty if it is missing. Sets an unstated unit to the one
/// that makes it a date of this century, otherwise to seconds. Throws if the cell is not a time.
[[nodiscard]] std::optional<std::int64_t> time_in(const CsvReader& reader, std::size_t column,
                                                  TimeUnit& unit);
/// The same from column 0, plus column 1 (nanoseconds) if `time` has two.
[[nodiscard]] std::optional<std::int64_t> time_in(const CsvReader& reader, TimeColumn& time);

/// Throws if times that were read as seconds have another unit.
void require_seconds(const std::vector<std::int64_t>& times_ns, const std::string& table,
                     const std::string& column);

}  // namespace odomd::tools
