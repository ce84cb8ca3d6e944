// The meaning of each column of the tables, from the options of odom import, and its values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/core/config_toml.hpp"
#include "tools/cli/output.hpp"
#include "tools/import/time_column.hpp"

namespace odomd::tools {

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
