// The time column of a table: seconds to nanoseconds, seconds and nanoseconds in two columns, or
// times of day.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/import/csv_table.hpp"

namespace odomd::tools {

enum class TimeUnit : std::uint8_t { unstated, s, ms, us, ns, hhmmss };

/// "s", "ms", "us", "ns", "hhmmss", and what headers have for them.
[[nodiscard]] std::optional<TimeUnit> time_unit(std::string_view text);

struct TimeColumn {
  std::vector<std::string> columns;  ///< one, or those of the seconds and of the nanoseconds
  TimeUnit unit = TimeUnit::unstated;
};

/// The time in a table whose map names none, by the names that tools give it. Throws
/// std::invalid_argument with the table's columns if there is none.
[[nodiscard]] TimeColumn usual_time(const CsvTable& table);

class TimeReader {
 public:
  /// The table has the columns.
  TimeReader(const CsvTable& table, const TimeColumn& column);

  /// In the current row; nothing where it is missing. An unstated unit is the header's, else that
  /// in which the first time is a date of this century, else seconds. Throws
  /// std::invalid_argument for what is no time.
  [[nodiscard]] std::optional<std::int64_t> time_ns();

  [[nodiscard]] std::string column_name() const;
  /// Whether the unit is neither stated nor that of a date.
  [[nodiscard]] bool is_guessed() const { return guessed_; }

 private:
  [[nodiscard]] std::optional<std::int64_t> parse(std::string text) const;

  const CsvTable& table_;
  std::vector<std::size_t> columns_;
  TimeUnit unit_;
  bool guessed_ = false;
};

}  // namespace odomd::tools
