// Times as tables have them: seconds to nanoseconds, seconds and nanoseconds in two columns, or
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
  std::vector<std::string> columns;  ///< one, or those of the seconds and of the nanoseconds
  TimeUnit unit = TimeUnit::unstated;
};

/// "s", "ms", "us", "ns" and "hhmmss"; anything else: unstated.
[[nodiscard]] TimeUnit time_unit(std::string_view text);

/// "km/h" of "speed" in "speed (km/h)", and of the names that begin a comment the mark is left out.
struct NameAndUnit {
  std::string_view name, unit;
};
[[nodiscard]] NameAndUnit split_unit(std::string_view column);

/// "", "nan", "n/a", ...
[[nodiscard]] bool is_missing(std::string_view cell);

/// The column that is the time by the names that tools give it: the sensor's own stamp before the
/// recorder's.
[[nodiscard]] std::optional<TimeColumn> usual_time(const std::vector<std::string>& columns);

/// Takes the unit that the table states, in the header, below it, or as in "time_ms".
void take_unit(TimeColumn& time, std::string_view unit_of_table);

/// In the reader's current row; nothing where it is missing. An unstated unit becomes the one in
/// which this time is a date of this century, else seconds. Throws at what is no time.
[[nodiscard]] std::optional<std::int64_t> time_in(const CsvReader& reader, std::size_t column,
                                                  TimeUnit& unit);
/// The same of the first column, and if need be the second.
[[nodiscard]] std::optional<std::int64_t> time_in(const CsvReader& reader, TimeColumn& time);

/// Throws where times that were taken for seconds have another unit.
void require_seconds(const std::vector<std::int64_t>& times_ns, const std::string& table,
                     const std::string& column);

}  // namespace odomd::tools
