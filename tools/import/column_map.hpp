// The meaning of each column of the tables, from the options of odom import, and its values;
// the times of the tables.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/core/config_toml.hpp"
#include "tools/cli/csv.hpp"
#include "tools/cli/output.hpp"

namespace odomd::tools {

// The times of tables: in s, ms, us or ns, in two columns (seconds and nanoseconds), or as times of
// day.

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

/// A column that is mapped to a role of [can.signals] or to a field of a pose:
/// quantity in SI = factor * value + offset.
struct MappedColumn {
  std::string role;  ///< "yaw_rate", "camera.x"
  std::string name;  ///< of the column; empty: offset is the quantity
  toml::table keys;  ///< as for a role of [can.signals]
  double factor = 0.0, offset = 0.0;
  std::string unit;  ///< of the column
  bool unit_stated = true;
  TimeUnit time_unit = TimeUnit::unstated;  ///< of camera.arrival
  std::int64_t latency_ns = 0;
  daemon::SignalSettings settings;

  // Filled by read_tables().
  std::size_t table = 0;       ///< index of its table
  std::string place;           ///< "imu.csv: gyro_z"
  std::vector<double> values;  ///< in SI, one per row of the table; NaN: missing

  [[nodiscard]] bool is_sensor() const { return role.find('.') == std::string::npos; }
  [[nodiscard]] double at(std::size_t row) const { return name.empty() ? offset : values[row]; }
};

struct TimedTable {
  std::string name;
  std::string time_column;             ///< filled by read_tables(), like the times
  std::vector<std::int64_t> times_ns;  ///< of the rows that have a time; non-decreasing
};

struct ColumnMap {
  std::vector<TimedTable> tables;
  std::vector<TimeColumn> times;
  std::vector<MappedColumn> columns;
};

struct MapSources {
  std::vector<std::string> tables;
  std::vector<std::string> columns;  ///< "yaw_rate=gyro_z,unit=deg/s"
  std::vector<std::string> times;    ///< "stamp.sec+stamp.nanosec", "t,unit=ms"; tried first
  std::filesystem::path config;  ///< its roles' latency, sigma, timeout, dead_band are the defaults
};

/// Throws std::invalid_argument that names option and key.
[[nodiscard]] ColumnMap read_map(const MapSources& sources);

/// Computes factor and offset. The unit is the stated one, otherwise that of the table, otherwise
/// SI.
void read_keys(MappedColumn& column, std::string_view unit_of_table);

/// Reads the tables and fills the columns. Detects delimiters, quotes, decimal commas, lines before
/// the header and a row of units below it. "imu.csv:gyro_z" and "imu:gyro_z" name a column of one
/// table. Values of camera.arrival are seconds after the time of the row. Throws
/// std::invalid_argument that names the file, and the line or the nearest column.
void read_tables(ColumnMap& map, const ReportProgress& report, std::vector<std::string>& warnings);

}  // namespace odomd::tools
