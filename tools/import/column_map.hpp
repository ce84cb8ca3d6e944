// Which columns of tables are what: the map of odom import, from a TOML file and from options; and
// what the tables hold of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/core/config.hpp"
#include "daemon/core/config_toml.hpp"
#include "tools/cli/progress.hpp"
#include "tools/import/time_column.hpp"

namespace odomd::tools {

/// A column and the role of [can.signals] or the field of a pose that it is:
/// quantity in SI = factor * value + offset.
struct MappedColumn {
  std::string role;  ///< "yaw_rate", "camera.x"
  std::string name;  ///< of the column; empty: offset is the quantity
  toml::table keys;  ///< those of a role
  double factor = 0.0, offset = 0.0;
  std::string unit;  ///< of the column
  bool unit_stated = true;
  TimeUnit time_unit = TimeUnit::unstated;  ///< of camera.arrival
  std::int64_t latency_ns = 0;
  daemon::SignalSettings settings;

  // Filled by read_tables().
  std::size_t table = 0;       ///< its index
  std::string place;           ///< "imu.csv: gyro_z"
  std::vector<double> values;  ///< in SI, one per row of the table; NaN: missing

  [[nodiscard]] bool is_sensor() const { return role.find('.') == std::string::npos; }
  [[nodiscard]] double at(std::size_t row) const { return name.empty() ? offset : values[row]; }
};

struct TimedTable {
  std::string name;
  std::string time_column;             ///< filled by read_tables(), as the times
  std::vector<std::int64_t> times_ns;  ///< of the rows that have one; never falling
};

struct ColumnMap {
  std::filesystem::path file;  ///< or the option that stands for it
  std::vector<TimedTable> tables;
  std::vector<TimeColumn> times;
  std::vector<MappedColumn> columns;
};

struct MapSources {
  std::vector<std::string> tables;  ///< go before the map's, as all options do
  std::filesystem::path map;
  std::vector<std::string> columns;  ///< "yaw_rate=gyro_z,unit=deg/s"
  std::vector<std::string> times;    ///< "stamp.sec+stamp.nanosec", "t,unit=ms"
  std::filesystem::path config;  ///< its roles' latency, sigma, timeout, dead_band are the defaults
};

/// Throws std::invalid_argument that names file, line and key.
[[nodiscard]] ColumnMap read_map(const MapSources& sources);

/// Works out factor and offset. The unit of the table counts where the map states none; neither:
/// SI.
void read_keys(MappedColumn& column, std::string_view unit_of_table,
               const std::filesystem::path& file);

/// Reads the tables and fills the columns: delimiters, quotes, decimal commas, lines before the
/// header and a row of units below it are found out. "imu.csv:gyro_z" and "imu:gyro_z" name a
/// column of one table. Values of camera.arrival are seconds after the time of the row. Throws
/// std::invalid_argument that names the file, and the line or the nearest column.
void read_tables(ColumnMap& map, const ReportProgress& report, std::vector<std::string>& warnings);

}  // namespace odomd::tools
