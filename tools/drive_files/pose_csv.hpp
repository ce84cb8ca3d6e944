// The pose file: one row per tick, written by replay and `odom pose --follow --csv`.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>

#include <odom/types.h>

#include "daemon/core/record.hpp"

namespace odomd::tools {

/// t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode and, after these: tick, the pose in the
/// odometry frame, reset_count, conditions (number), the covariances that sigmas leave out,
/// steering and accelerations. Columns are only ever added at the end.
void write_pose_header(std::ostream& out);

/// Appends one row with its newline. `t_ns` is the time of validity on the clock of the file.
void append_pose_row(std::string& out, const odom_pose& pose, std::int64_t t_ns);

/// The same with the calibrations as further columns, for callers with the complete record of every
/// tick.
void write_record_header(std::ostream& out);
void append_record_row(std::string& out, const daemon::TickRecord& record, std::int64_t t_ns);

/// "tracking", ...; "mode 9" for a mode that is not known here.
[[nodiscard]] std::string mode_name(std::uint32_t mode);

}  // namespace odomd::tools
