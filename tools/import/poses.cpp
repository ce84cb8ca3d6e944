#include "tools/import/poses.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>

namespace odomd::tools {
namespace {

constexpr double earth_radius = 6371008.8;  // m, mean

/// The fields of one kind of pose, row by row.
class Fields {
 public:
  Fields(std::string_view group, const std::vector<PoseColumn>& columns,
         const std::vector<Place>& places, const Tables& tables)
      : group_(group), columns_(columns), places_(places) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].constant) continue;
      if (rows_ != nullptr && rows_ != &tables.rows[places[i].table])
        throw std::invalid_argument(fmt::format(
            "{}.{}: is in another table than the other columns of {}; their times differ", group,
            columns[i].field, group));
      rows_ = &tables.rows[places[i].table];
    }
  }

  [[nodiscard]] bool has(std::string_view field) const { return index_of(field).has_value(); }
  void require(std::initializer_list<std::string_view> fields, std::string_view why) const {
    for (const std::string_view field : fields)
      if (!has(field))
        throw std::invalid_argument(
            fmt::format("{0}.{1} is missing: {2}; give --column {0}.{1}=...", group_, field, why));
    if (rows_ == nullptr)
      throw std::invalid_argument(fmt::format("{}: all of it are numbers, none a column", group_));
  }

  [[nodiscard]] const std::vector<std::int64_t>& times() const { return rows_->times_ns; }
  /// NaN: missing.
  [[nodiscard]] double at(std::string_view field, std::size_t row) const {
    const std::size_t i = index_of(field).value();
    const PoseColumn& column = columns_[i];
    const double value =
        column.constant ? *column.constant : rows_->values.at(places_[i].column)[row];
    return column.scale * column.factor * value + column.offset;
  }
  [[nodiscard]] std::int64_t time_at(std::string_view field, std::size_t row) const {
    return rows_->value_times_ns.at(places_[index_of(field).value()].column)[row];
  }

  void require_yaw() const {
    if (!has("qw")) return require({"yaw"}, "a pose needs a heading, or a quaternion (qz, qw)");
    require({"qz"}, "a quaternion needs it");
  }
  [[nodiscard]] double yaw(std::size_t row) const {
    if (!has("qw")) return at("yaw", row);
    const double x = has("qx") ? at("qx", row) : 0.0, y = has("qy") ? at("qy", row) : 0.0;
    const double z = at("qz", row), w = at("qw", row);
    const double size = w * w + x * x + y * y + z * z;
    if (!(size > 0.25 && size < 4.0)) return std::numeric_limits<double>::quiet_NaN();
    return std::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z);
  }

 private:
  [[nodiscard]] std::optional<std::size_t> index_of(std::string_view field) const {
    const auto found = std::ranges::find(columns_, field, &PoseColumn::field);
    if (found == columns_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - columns_.begin());
  }

  std::string_view group_;
  const std::vector<PoseColumn>& columns_;
  const std::vector<Place>& places_;
  const TableRows* rows_ = nullptr;
};

bool all_finite(std::initializer_list<double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

}  // namespace

ImportedCamera camera_of(const ColumnMap& map, const Tables& tables) {
  ImportedCamera camera;
  if (map.camera.empty()) return camera;
  const Fields fields("camera", map.camera, tables.camera, tables);
  fields.require({"x", "y"}, "a pose needs it");
  fields.require_yaw();
  fields.require({"sigma_x", "sigma_yaw"},
                 "how far a pose is off (standard deviation), as a number or a column");
  for (std::size_t row = 0; row < fields.times().size(); ++row) {
    const double latency = fields.has("latency") ? fields.at("latency", row) : 0.0;
    estimator::CameraPose pose{.capture_ns = fields.times()[row],
                               .x = fields.at("x", row),
                               .y = fields.at("y", row),
                               .yaw = fields.yaw(row),
                               .sigma_x = fields.at("sigma_x", row),
                               .sigma_yaw = fields.at("sigma_yaw", row)};
    pose.sigma_y = fields.has("sigma_y") ? fields.at("sigma_y", row) : pose.sigma_x;
    pose.arrival_ns = fields.has("arrival") ? fields.time_at("arrival", row) : pose.capture_ns;
    if (!all_finite({pose.x, pose.y, pose.yaw, latency}) || pose.arrival_ns == no_time ||
        !(std::min({pose.sigma_x, pose.sigma_y, pose.sigma_yaw}) > 0.0)) {
      ++camera.left_out;
      continue;
    }
    pose.arrival_ns += std::llround(latency * 1e9);
    camera.poses.push_back(pose);
  }
  std::ranges::stable_sort(camera.poses, {}, &estimator::CameraPose::arrival_ns);
  return camera;
}

// Latitude and longitude become metres to the east and north of the first row.
ImportedTruth truth_of(const ColumnMap& map, const Tables& tables) {
  ImportedTruth truth;
  if (map.truth.empty()) return truth;
  const Fields fields("truth", map.truth, tables.truth, tables);
  const bool is_global = fields.has("latitude");
  if (is_global)
    fields.require({"longitude"}, "a position needs it");
  else
    fields.require({"x", "y"}, "a position needs it, or latitude and longitude");
  fields.require_yaw();
  truth.has_motion = fields.has("vx") && fields.has("vy") && fields.has("yaw_rate");
  std::optional<std::array<double, 2>> first;
  for (std::size_t row = 0; row < fields.times().size(); ++row) {
    ImportedTruth::Row point{.time_ns = fields.times()[row], .yaw = fields.yaw(row)};
    if (is_global) {
      const double latitude = fields.at("latitude", row), longitude = fields.at("longitude", row);
      if (!first && all_finite({latitude, longitude})) first = {latitude, longitude};
      const auto [latitude_0, longitude_0] = first.value_or(std::array{0.0, 0.0});
      point.x = earth_radius * std::cos(latitude_0) * (longitude - longitude_0);
      point.y = earth_radius * (latitude - latitude_0);
    } else {
      point.x = fields.at("x", row);
      point.y = fields.at("y", row);
    }
    if (truth.has_motion)
      point.motion = {fields.at("vx", row), fields.at("vy", row), fields.at("yaw_rate", row)};
    if (all_finite(
            {point.x, point.y, point.yaw, point.motion[0], point.motion[1], point.motion[2]}))
      truth.rows.push_back(point);
    else
      ++truth.left_out;
  }
  return truth;
}

}  // namespace odomd::tools
