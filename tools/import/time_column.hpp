// Times as tables have them: seconds to nanoseconds, seconds and nanoseconds in two columns, or
// times of day.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

/// Of a column by its name: "Time [ms]", "time_ms".
[[nodiscard]] TimeUnit unit_in_name(std::string_view column);

/// The column that is the time by the names that tools give it: the sensor's own stamp before the
/// recorder's.
[[nodiscard]] std::optional<TimeColumn> usual_time(const std::vector<std::string>& columns);

/// The unit in which a time is a date of this century, else seconds.
[[nodiscard]] TimeUnit unit_by_size(std::string_view text);

/// Nothing for what is no time. With colons the unit does not matter: "10:21:07.25",
/// "2026-01-16T10:21:07.25Z".
[[nodiscard]] std::optional<std::int64_t> parse_time(std::string text, TimeUnit unit);

}  // namespace odomd::tools
