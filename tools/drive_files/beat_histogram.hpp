// Histograms of a beat: wake-up latency, and execution time if it is known.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include <odom/types.h>

#include "can_protocol/frame.hpp"

namespace odomd::tools {

using BeatBuckets = std::array<std::uint64_t, ODOM_HISTOGRAM_BUCKETS>;

struct BeatHistogram {
  std::string source;  ///< the file, or the segment
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;  ///< skipped tick numbers
  BeatBuckets wakeup{};      ///< in the buckets of odom_beat
  BeatBuckets execution{};   ///< all zero if it was not measured
  std::int64_t max_wakeup_ns = 0;
  std::int64_t max_execution_ns = 0;
};

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

/// The histograms of a running daemon, since its start.
[[nodiscard]] BeatHistogram beat_histogram(const odom_beat& beat, const std::string& source);

/// Reads a beat.csv; only its first three columns are required. Throws std::invalid_argument with
/// file, line and column if it is not usable.
[[nodiscard]] BeatHistogram read_beat_log(const std::filesystem::path& file);

/// The edges of a bucket [us], for a picture: the first and the last bucket are drawn as wide as
/// the others, although they begin at 0 and have no end.
struct BucketEdges {
  double low_us = 0.0;
  double high_us = 0.0;
};
[[nodiscard]] BucketEdges edges_of(std::size_t bucket);

/// The percentile [us] for a share of the ticks: the upper edge of its bucket, at most `max_ns`.
[[nodiscard]] double percentile_us(const BeatBuckets& buckets, double share, std::int64_t max_ns);

}  // namespace odomd::tools
