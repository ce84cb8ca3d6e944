// The mapped columns of several tables, each with its own times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/cli/progress.hpp"
#include "tools/import/column_map.hpp"

namespace odomd::tools {

/// One table: its rows that have a time, and of these its mapped columns.
struct TableRows {
  std::string name;
  std::string time_column;
  std::vector<std::int64_t> times_ns;                 ///< never falling
  std::map<std::size_t, std::vector<double>> values;  ///< by the column's index; NaN: missing
  std::map<std::size_t, std::vector<std::int64_t>> value_times_ns;  ///< of columns that are times
  std::size_t without_time = 0;
};

/// Where the values of a mapped column are.
struct Place {
  std::size_t table = 0;
  std::size_t column = 0;
  std::string name;  ///< "imu.csv: gyro_z"
};

struct Tables {
  std::vector<TableRows> rows;
  std::vector<Place> sensors, camera, truth;  ///< as the columns of the map
};

/// Time stands for a missing one.
inline constexpr std::int64_t no_time = INT64_MIN;

/// Reads the tables of the map, whose columns take over the tables' units. "imu.csv:gyro_z" and
/// "imu:gyro_z" name a column of one table. Throws std::invalid_argument that names the file, and
/// the line or the nearest columns.
[[nodiscard]] Tables read_tables(ColumnMap& map, const ReportProgress& report);

}  // namespace odomd::tools
