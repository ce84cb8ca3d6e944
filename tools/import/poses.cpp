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

/// The fields of one kind of pose, row by row.
class Fields {
 public:
  Fields(std::string_view group, const std::vector<MappedColumn>& columns,
         const std::vector<TableRows>& tables)
      : group_(group), columns_(columns) {
    const MappedColumn* first = nullptr;
    for (const MappedColumn& column : columns) {
      if (column.name.empty()) continue;
      if (first == nullptr) first = &column;
      if (first->table != column.table)
        throw std::invalid_argument(fmt::format(
            "{}: is in another table than {}; their times differ", column.role, first->role));
      times_ns_ = &tables[column.table].times_ns;
    }
    if (times_ns_ == nullptr)
      throw std::invalid_argument(fmt::format("{}: all of it are numbers, none a column", group));
    require({"x", "y"}, "a pose needs it");
    if (has("qw"))
      require({"qz"}, "a quaternion needs it");
    else
      require({"yaw"}, "a pose needs a heading, or a quaternion (qz, qw)");
  }

  [[nodiscard]] bool has(std::string_view field) const { return find(field) != nullptr; }
  void require(std::initializer_list<std::string_view> fields, std::string_view why) const {
    for (const std::string_view field : fields)
      if (!has(field))
        throw std::invalid_argument(
            fmt::format("{0}.{1} is missing: {2}; give --column {0}.{1}=...", group_, field, why));
  }

  [[nodiscard]] const std::vector<std::int64_t>& times_ns() const { return *times_ns_; }
  /// NaN: missing.
  [[nodiscard]] double at(std::string_view field, std::size_t row, double without = 0.0) const {
    const MappedColumn* column = find(field);
    if (column == nullptr) return without;
    return column->name.empty() ? column->offset : column->values[row];
  }
  [[nodiscard]] double yaw(std::size_t row) const {
    if (!has("qw")) return at("yaw", row);
    const double x = at("qx", row), y = at("qy", row), z = at("qz", row), w = at("qw", row);
    const double size = w * w + x * x + y * y + z * z;
    if (!(size > 0.25 && size < 4.0)) return std::numeric_limits<double>::quiet_NaN();
    return std::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z);
  }

 private:
  [[nodiscard]] const MappedColumn* find(std::string_view field) const {
    const auto found = std::ranges::find_if(columns_, [&](const MappedColumn& column) {
      return std::string_view(column.role).substr(group_.size() + 1) == field;
    });
    return found == columns_.end() ? nullptr : &*found;
  }

  std::string_view group_;
  const std::vector<MappedColumn>& columns_;
  const std::vector<std::int64_t>* times_ns_ = nullptr;
};

}  // namespace

PoseText camera_of(const ColumnMap& map, const std::vector<TableRows>& tables,
                   std::int64_t shift_ns) {
  PoseText result;
  if (map.camera.empty()) return result;
  const Fields fields("camera", map.camera, tables);
  fields.require({"sigma_x", "sigma_yaw"},
                 "how far a pose is off (standard deviation), as a number or a column");
  std::vector<estimator::CameraPose> poses;
  for (std::size_t row = 0; row < fields.times_ns().size(); ++row) {
    estimator::CameraPose pose{.capture_ns = fields.times_ns()[row] + shift_ns,
                               .x = fields.at("x", row),
                               .y = fields.at("y", row),
                               .yaw = fields.yaw(row),
                               .sigma_x = fields.at("sigma_x", row),
                               .sigma_yaw = fields.at("sigma_yaw", row)};
    pose.sigma_y = fields.at("sigma_y", row, pose.sigma_x);
    const double late_s = fields.at("arrival", row) + fields.at("latency", row);
    if (!std::isfinite(pose.x + pose.y + pose.yaw) || !(std::abs(late_s) < 1e6) ||
        !(std::min({pose.sigma_x, pose.sigma_y, pose.sigma_yaw}) > 0.0)) {
      ++result.left_out;
      continue;
    }
    pose.arrival_ns = pose.capture_ns + std::llround(late_s * 1e9);
    poses.push_back(pose);
  }
  std::ranges::stable_sort(poses, {}, &estimator::CameraPose::arrival_ns);
  result.rows = poses.size();
  result.text = fmt::format("{}\n", camera_columns);
  for (const estimator::CameraPose& pose : poses) append_camera_row(result.text, pose);
  return result;
}

PoseText truth_of(const ColumnMap& map, const std::vector<TableRows>& tables,
                  std::int64_t shift_ns) {
  PoseText result;
  if (map.truth.empty()) return result;
  const Fields fields("truth", map.truth, tables);
  const bool has_motion = fields.has("vx") && fields.has("vy") && fields.has("yaw_rate");
  result.text = has_motion ? "t,x,y,yaw,vx,vy,yaw_rate\n" : "t,x,y,yaw\n";
  for (std::size_t row = 0; row < fields.times_ns().size(); ++row) {
    std::vector<double> values{fields.at("x", row), fields.at("y", row), fields.yaw(row)};
    if (has_motion)
      for (const char* field : {"vx", "vy", "yaw_rate"}) values.push_back(fields.at(field, row));
    if (!std::ranges::all_of(values, [](double value) { return std::isfinite(value); })) {
      ++result.left_out;
      continue;
    }
    ++result.rows;
    append_seconds(result.text, fields.times_ns()[row] + shift_ns);
    for (const double value : values) append_number(result.text += ',', value);
    result.text += '\n';
  }
  return result;
}

}  // namespace odomd::tools
