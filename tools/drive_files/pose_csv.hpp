// Pose files of odom replay and odom record: one row per tick.
#pragma once

#include <cstdint>
#include <future>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include <odom/types.h>

#include "daemon/core/record.hpp"

namespace odomd::tools {

/// t,x,y,yaw,vx,vy,yaw_rate,sigma_x,sigma_y,sigma_yaw,mode and, after these: tick, the pose in the
/// odometry frame, reset_count, conditions (number), the covariances that sigmas leave out,
/// steering and accelerations. Columns are only ever added at the end.
[[nodiscard]] std::string pose_header();

/// Appends one row with its newline. `t_ns` is the time of validity on the clock of the file.
void append_pose_row(std::string& out, const odom_pose& pose, std::int64_t t_ns);

/// The same with the calibrations and then their standard deviations (sigma_gyro_bias, ...; 0: not
/// estimated) as further columns, for callers with the complete record of every tick.
[[nodiscard]] std::string record_header();
void append_record_row(std::string& out, const daemon::TickRecord& record, std::int64_t t_ns);

/// "tracking", ...; "mode 9" for a mode that is not known here.
[[nodiscard]] std::string mode_name(std::uint32_t mode);

/// Rows come out in the order in which they were added. Another thread formats them, so that a
/// replay does not wait for its output. One thread may add.
class PoseFile {
 public:
  /// Writes the header. `out` belongs to this object until finish() or its destruction.
  explicit PoseFile(std::ostream& out);
  ~PoseFile();  ///< without finish(): the last rows may be missing
  PoseFile(const PoseFile&) = delete;
  PoseFile& operator=(const PoseFile&) = delete;

  /// `t_ns` is the time of validity on the clock of the file.
  void add(const daemon::TickRecord& record, std::int64_t t_ns);
  /// Returns when all rows are in `out`.
  void finish();

 private:
  struct Row {
    daemon::TickRecord record;
    std::int64_t t_ns;
  };
  void hand_over();

  std::ostream& out_;
  std::vector<Row> added_;
  std::vector<Row> written_;  // used by the writing thread, like text_
  std::string text_;
  std::future<void> writing_;  // declared last: its destructor waits for the thread
};

}  // namespace odomd::tools
