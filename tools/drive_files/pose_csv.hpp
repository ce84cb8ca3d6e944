// The numbers of a pose: columns of pose files from odom replay and odom record (one row per tick),
// and fields of all outputs to plotting tools, live or recorded, which name them PoseField::path.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include <odom/types.h>
#include <nlohmann/json_fwd.hpp>

#include "daemon/core/record.hpp"

namespace odomd::tools {

/// t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode and, after these: tick, the pose in the
/// odometry frame, reset_count, conditions (number), the covariances that sigmas leave out,
/// steering and accelerations. Columns are only ever added at the end.
[[nodiscard]] std::string pose_header();

/// Appends one row with its newline. `t_ns` is the time of validity on the clock of the file.
void append_pose_row(std::string& out, const odom_pose& pose, std::int64_t t_ns);

/// Like pose_header() and append_pose_row(), with further columns from the tick's complete record:
/// the calibrations, then their standard deviations (sigma_gyro_bias, ...; 0: not estimated).
[[nodiscard]] std::string record_header();
void append_record_row(std::string& out, const daemon::TickRecord& record, std::int64_t t_ns);

/// "tracking", ...; "mode 9" for a mode that is not known here.
[[nodiscard]] std::string mode_name(std::uint32_t mode);

/// One number. SI units.
struct PoseField {
  std::string path;         ///< "map/x": its name in plotting tools
  std::string_view column;  ///< in a pose file; empty: not in the file
  std::function<double(const odom_pose& pose, const odom_details& details)> value;
  bool is_count = false;  ///< an integer
};

[[nodiscard]] std::span<const PoseField> pose_fields();

/// The field `mode`, an odom_mode; a pose file contains its name.
inline constexpr const char* mode_path = "mode";

/// Sets the field's member; if its path has two parts, in the group's object. For the mode, also
/// sets `mode_name`. A number that is not finite becomes null.
void set_field(nlohmann::ordered_json& object, const PoseField& field, double value);

}  // namespace odomd::tools
