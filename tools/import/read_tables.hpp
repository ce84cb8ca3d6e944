// The mapped columns of several tables, each with its own times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/cli/progress.hpp"
#include "tools/import/column_map.hpp"

namespace odomd::tools {

struct TableRows {
  std::string name;
  std::string time_column;
  std::vector<std::int64_t> times_ns;  ///< of the rows that have one; never falling
};

/// Reads the tables of the map and fills its columns: delimiters, quotes, decimal commas, lines
/// before the header and a row of units below it are found out. "imu.csv:gyro_z" and "imu:gyro_z"
/// name a column of one table. Values of camera.arrival are seconds after the time of the row.
/// Throws std::invalid_argument that names the file, and the line or the nearest column.
[[nodiscard]] std::vector<TableRows> read_tables(ColumnMap& map, const ReportProgress& report,
                                                 std::vector<std::string>& warnings);

}  // namespace odomd::tools
