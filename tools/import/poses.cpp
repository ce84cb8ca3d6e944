#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "tools/cli/csv.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/table.hpp"
#include "tools/import/import.hpp"

namespace odomd::tools {
namespace {

struct Row {
  std::int64_t time_ns = 0;
  std::vector<double> values;  ///< x, y, yaw and the other fields
};

double yaw_of(double w, double x, double y, double z) {
  const double size = w * w + x * x + y * y + z * z;
  if (!(size > 0.25 && size < 4.0)) return std::numeric_limits<double>::quiet_NaN();
  return std::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z);
}

const MappedColumn* column_of(const ColumnMap& map, std::string_view role) {
  const auto found = std::ranges::find(map.columns, role, &MappedColumn::role);
  return found == map.columns.end() ? nullptr : &*found;
}

void require(const ColumnMap& map, const std::string& role, std::string_view what) {
  if (column_of(map, role) == nullptr)
    throw std::invalid_argument(
        fmt::format("{0} is missing: {1}; give --column {0}=...", role, what));
}

/// The rows that have all values; an unmapped field is 0. All columns must be in one table.
std::vector<Row> rows_of(const std::string& group, const ColumnMap& map,
                         std::initializer_list<const char*> others, PoseText& result) {
  const bool is_quaternion = column_of(map, group + ".qw") != nullptr;
  for (const char* field : {"x", "y", is_quaternion ? "qz" : "yaw"})
    require(map, group + '.' + field, "a pose has x, y and yaw, or qz and qw");
  const MappedColumn* first = nullptr;
  for (const MappedColumn& column : map.columns) {
    if (column.name.empty() || !column.role.starts_with(group + '.')) continue;
    if (first == nullptr) first = &column;
    if (first->table != column.table)
      throw std::invalid_argument(fmt::format("{}: is in another table than {}; their times differ",
                                              column.role, first->role));
  }
  if (first == nullptr)
    throw std::invalid_argument(group + ": has only constants; map a column to one of its fields");
  std::vector<Row> rows;
  for (std::size_t i = 0; i < first->values.size(); ++i) {
    const auto at = [&](const char* field) {
      const MappedColumn* column = column_of(map, group + '.' + field);
      return column == nullptr ? 0.0 : column->at(i);
    };
    Row row{map.tables[first->table].times_ns[i], {at("x"), at("y")}};
    row.values.push_back(is_quaternion ? yaw_of(at("qw"), at("qx"), at("qy"), at("qz"))
                                       : at("yaw"));
    for (const char* field : others) row.values.push_back(at(field));
    if (std::ranges::all_of(row.values, [](double value) { return std::isfinite(value); }))
      rows.push_back(std::move(row));
    else
      ++result.left_out;
  }
  result.rows = rows.size();
  return rows;
}

bool has_group(const ColumnMap& map, std::string_view group) {
  return std::ranges::any_of(
      map.columns, [&](const MappedColumn& column) { return column.role.starts_with(group); });
}

}  // namespace

PoseText camera_of(const ColumnMap& map) {
  PoseText result;
  if (!has_group(map, "camera.")) return result;
  const char* sigma_y = column_of(map, "camera.sigma_y") != nullptr ? "sigma_y" : "sigma_x";
  const auto rows =
      rows_of("camera", map, {"sigma_x", sigma_y, "sigma_yaw", "arrival", "latency"}, result);
  for (const char* sigma : {"camera.sigma_x", "camera.sigma_yaw"})
    require(map, sigma, "how far a pose is off (standard deviation), as a number or a column");
  std::vector<estimator::CameraPose> poses;
  for (const Row& row : rows) {
    const std::vector<double>& v = row.values;
    const double late_s = v[6] + v[7];
    constexpr double max_late_s = 1e6;
    if (!(std::min({v[3], v[4], v[5]}) > 0.0) || std::abs(late_s) > max_late_s) continue;
    poses.push_back({row.time_ns, row.time_ns + std::llround(late_s * 1e9), v[0], v[1], v[2], v[3],
                     v[4], v[5]});
  }
  result.left_out += result.rows - poses.size();
  result.rows = poses.size();
  std::ranges::stable_sort(poses, {}, &estimator::CameraPose::arrival_ns);
  result.text = header_of<estimator::CameraPose>(camera_columns);
  for (const estimator::CameraPose& pose : poses) append_row(result.text, camera_columns, pose);
  return result;
}

PoseText truth_of(const ColumnMap& map) {
  PoseText result;
  if (!has_group(map, "truth.")) return result;
  const bool has_motion = std::ranges::none_of(
      std::initializer_list<const char*>{"truth.vx", "truth.vy", "truth.yaw_rate"},
      [&](const char* role) { return column_of(map, role) == nullptr; });
  result.text = has_motion ? "t,x,y,yaw,vx,vy,yaw_rate\n" : "t,x,y,yaw\n";
  for (const Row& row : rows_of("truth", map, {"vx", "vy", "yaw_rate"}, result)) {
    append_seconds(result.text, row.time_ns);
    for (std::size_t i = 0; i < (has_motion ? 6 : 3); ++i)
      append_number(result.text += ',', row.values[i]);
    result.text += '\n';
  }
  return result;
}

}  // namespace odomd::tools
