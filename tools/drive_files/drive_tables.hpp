// The tables of a drive besides its trajectories: the poses of its camera, the timing of its ticks,
// and the filter's verdict on every sample.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <odom/types.h>

#include "can_protocol/frame.hpp"
#include "daemon/diagnostics/diagnostic.hpp"
#include "estimator/common/measurement.hpp"
#include "tools/cli/csv.hpp"

namespace odomd::tools {

// Camera logs: t_arrival,t_capture,x,y,yaw,sigma_x,sigma_y,sigma_yaw, on the clock of the CAN log.

inline constexpr auto camera_columns = [](auto&& cell, auto& pose) {
  cell("t_arrival", pose.arrival_ns);
  cell("t_capture", pose.capture_ns);
  cell("x", pose.x);
  cell("y", pose.y);
  cell("yaw", pose.yaw);
  cell("sigma_x", pose.sigma_x);
  cell("sigma_y", pose.sigma_y);
  cell("sigma_yaw", pose.sigma_yaw);
};

struct CameraLog {
  /// In order of arrival; poses of the camera's reference point, not of the centre of gravity.
  std::vector<estimator::CameraPose> poses;
  diagnostics::Diagnostics warnings;
};

/// Reads a whole log. Throws std::invalid_argument with file, line and column if it is not usable:
/// a missing column, a field that is not a finite number, a sigma that is not positive. A last line
/// that is cut off, rows out of the order of arrival, and poses that arrive before their capture
/// give warnings.
[[nodiscard]] CameraLog read_camera_log(const std::filesystem::path& file);

/// The warning about a log without a single pose.
[[nodiscard]] diagnostics::Diagnostic no_camera_pose(const std::filesystem::path& file);

/// A reader for the camera's columns. next_camera_pose() reads a row; returns nothing at the end.
[[nodiscard]] CsvReader camera_reader(std::istream& input, const std::string& name);
[[nodiscard]] std::optional<estimator::CameraPose> next_camera_pose(CsvReader& reader);

// The ticks of a recording, and histograms of a beat: wake-up latency, and execution time if it is
// known.

using BeatBuckets = std::span<const std::uint64_t, ODOM_HISTOGRAM_BUCKETS>;

/// A row of the beat.csv of a recording (docs/recording.md): counts are since the start of the
/// daemon, or of the recording.
struct BeatRow {
  std::uint64_t tick = 0;
  std::int64_t time_ns = 0, woke_ns = 0;  ///< on the recording's clock
  std::array<std::uint64_t, can::max_buses> frames{};
  std::uint64_t camera_messages = 0;
  std::uint64_t camera_poses = 0;
  std::uint32_t conditions = 0;
  std::string realtime_offset_ns;  ///< not used by odom; as in the file
  std::string record;              ///< fingerprint of what was published, 16 hexadecimal digits
};
inline constexpr auto beat_columns = [](auto&& cell, auto& row) {
  cell("tick", row.tick);
  cell("t", row.time_ns);
  cell("t_woke", row.woke_ns);
  for (std::size_t bus = 0; bus < row.frames.size(); ++bus)
    cell("frames_", row.frames[bus], std::string_view("01234567").substr(bus, 1));
  cell("camera_messages", row.camera_messages);
  cell("camera_poses", row.camera_poses);
  cell("conditions", row.conditions);
  cell("realtime_offset_ns", row.realtime_offset_ns);
  cell("record", row.record);
};

/// Of a beat.csv: ticks, missed (skipped numbers), wake-up latencies and the longest; all else is
/// 0: execution times are not measured. Only the first three columns are required. Throws
/// std::invalid_argument with file, line and column if it is not usable.
[[nodiscard]] odom_beat read_beat_log(const std::filesystem::path& file);

/// The edges of a bucket [us], for a picture: the first and the last bucket are drawn as wide as
/// the others, although they begin at 0 and have no end.
struct BucketEdges {
  double low_us = 0.0;
  double high_us = 0.0;
};
[[nodiscard]] BucketEdges edges_of(std::size_t bucket);

/// The percentile [us] for a share of the ticks: the upper edge of its bucket, at most `max_ns`.
[[nodiscard]] double percentile_us(BeatBuckets buckets, double share, std::int64_t max_ns);

// The filter's verdict on every sample: a file with a row per sample, in the order in which the
// ticks used them.
//
//   t         when the sample was taken [s], the log's clock
//   source    yaw_rate, ..., camera
//   verdict   fused, gated, ...
//   degrees   of freedom of the test: 1, camera 3; 0: not tested (an input, a sample never used, or
//             a pose that was accepted in spite of the test)
//   nu_1..3   the innovation, in the source's units (camera: x, y [m], yaw [rad])
//   sigma_1..3  expected standard deviations of nu: the roots of the diagonal of S
//   nis       νᵀS⁻¹ν
//
// Samples that were dropped together in a flood have the time of the newest of them.

[[nodiscard]] std::string innovation_header();
void append_innovation_rows(std::string& out, const estimator::Judgement& judgement);

/// Throws std::invalid_argument with file, line and column if the file is not usable.
[[nodiscard]] std::vector<estimator::Judgement> read_innovations(const std::filesystem::path& file);

}  // namespace odomd::tools
