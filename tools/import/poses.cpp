#include "tools/import/poses.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

#include "tools/cli/csv.hpp"
#include "tools/drive_files/camera_csv.hpp"

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

bool has(const std::vector<MappedColumn>& columns, std::string_view role) {
  return std::ranges::find(columns, role, &MappedColumn::role) != columns.end();
}

/// The rows that have all values; a field that is not mapped is 0.
std::vector<Row> rows_of(const std::string& group, const std::vector<MappedColumn>& columns,
                         std::initializer_list<const char*> others,
                         const std::vector<TableRows>& tables, PoseText& result) {
  const bool is_quaternion = has(columns, group + ".qw");
  for (const char* field : {"x", "y", is_quaternion ? "qz" : "yaw"})
    if (!has(columns, group + '.' + field))
      throw std::invalid_argument(fmt::format(
          "{0}.{1} is missing: a pose has x, y and yaw, or qz and qw; give --column {0}.{1}=...",
          group, field));
  const MappedColumn* first = nullptr;
  for (const MappedColumn& column : columns) {
    if (column.name.empty()) continue;
    if (first == nullptr) first = &column;
    if (first->table != column.table)
      throw std::invalid_argument(fmt::format("{}: is in another table than {}; their times differ",
                                              column.role, first->role));
  }
  if (first == nullptr)
    throw std::invalid_argument(group + ": all of it are numbers, none a column");
  const auto& times_ns = tables[first->table].times_ns;
  std::vector<Row> rows;
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    const auto at = [&](std::string_view field) {
      const auto found =
          std::ranges::find(columns, fmt::format("{}.{}", group, field), &MappedColumn::role);
      if (found == columns.end()) return 0.0;
      return found->name.empty() ? found->offset : found->values[i];
    };
    Row row{times_ns[i], {at("x"), at("y")}};
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

}  // namespace

PoseText camera_of(const ColumnMap& map, const std::vector<TableRows>& tables,
                   std::int64_t shift_ns) {
  PoseText result;
  if (map.camera.empty()) return result;
  const char* sigma_y = has(map.camera, "camera.sigma_y") ? "sigma_y" : "sigma_x";
  const auto rows =
      rows_of("camera", map.camera, {"sigma_x", sigma_y, "sigma_yaw", "arrival", "latency"}, tables,
              result);
  for (const char* sigma : {"camera.sigma_x", "camera.sigma_yaw"})
    if (!has(map.camera, sigma))
      throw std::invalid_argument(fmt::format(
          "{0} is missing: how far a pose is off (standard deviation), as a number or a "
          "column; give --column {0}=...",
          sigma));
  std::vector<estimator::CameraPose> poses;
  for (const Row& row : rows) {
    const std::vector<double>& v = row.values;
    const double late_s = v[6] + v[7];
    constexpr double max_late_s = 1e6;
    if (!(std::min({v[3], v[4], v[5]}) > 0.0) || std::abs(late_s) > max_late_s) continue;
    const std::int64_t capture_ns = row.time_ns + shift_ns;
    poses.push_back(
        {capture_ns, capture_ns + std::llround(late_s * 1e9), v[0], v[1], v[2], v[3], v[4], v[5]});
  }
  result.left_out += result.rows - poses.size();
  result.rows = poses.size();
  std::ranges::stable_sort(poses, {}, &estimator::CameraPose::arrival_ns);
  result.text = fmt::format("{}\n", camera_columns);
  for (const estimator::CameraPose& pose : poses) append_camera_row(result.text, pose);
  return result;
}

PoseText truth_of(const ColumnMap& map, const std::vector<TableRows>& tables,
                  std::int64_t shift_ns) {
  PoseText result;
  if (map.truth.empty()) return result;
  const bool has_motion =
      has(map.truth, "truth.vx") && has(map.truth, "truth.vy") && has(map.truth, "truth.yaw_rate");
  result.text = has_motion ? "t,x,y,yaw,vx,vy,yaw_rate\n" : "t,x,y,yaw\n";
  for (const Row& row : rows_of("truth", map.truth, {"vx", "vy", "yaw_rate"}, tables, result)) {
    append_seconds(result.text, row.time_ns + shift_ns);
    for (std::size_t i = 0; i < (has_motion ? 6 : 3); ++i)
      append_number(result.text += ',', row.values[i]);
    result.text += '\n';
  }
  return result;
}

}  // namespace odomd::tools
