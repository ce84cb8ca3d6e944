// How punctual a beat was: its wake-up latency, and how long its ticks worked where that is known.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include <odom/types.h>

namespace odomd::tools {

using BeatBuckets = std::array<std::uint64_t, ODOM_HISTOGRAM_BUCKETS>;

struct BeatHistogram {
  std::string source;  ///< the file, or the segment
  std::uint64_t ticks = 0;
  std::uint64_t missed = 0;  ///< numbers that were skipped
  BeatBuckets wakeup{};      ///< by the buckets of odom_beat
  BeatBuckets execution{};   ///< all zero where nobody has measured it
  std::int64_t max_wakeup_ns = 0;
  std::int64_t max_execution_ns = 0;
};

/// Of a running daemon, since its start.
[[nodiscard]] BeatHistogram beat_histogram(const odom_beat& beat, const std::string& source);

/// Of the beat.csv of a recording (docs/recording.md). Throws std::invalid_argument with file, line
/// and column where it is not usable.
[[nodiscard]] BeatHistogram read_beat_log(const std::filesystem::path& file);

/// The edges of a bucket [us], for a picture: the first and the last are drawn as wide
/// as the others, though the one begins at 0 and the other has no end.
struct BucketEdges {
  double low_us = 0.0;
  double high_us = 0.0;
};
[[nodiscard]] BucketEdges edges_of(std::size_t bucket);

/// The time [us] that a share of the ticks stayed below: the upper edge of the bucket that it falls
/// into, at most `max_ns`.
[[nodiscard]] double percentile_us(const BeatBuckets& buckets, double share, std::int64_t max_ns);

}  // namespace odomd::tools
