// Histograms of a beat: wake-up latency, and execution time if it is known.
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
  BeatBuckets execution{};   ///< all zero if it was not measured
  std::int64_t max_wakeup_ns = 0;
  std::int64_t max_execution_ns = 0;
};

/// Reads those of a running daemon, since its start.
[[nodiscard]] BeatHistogram beat_histogram(const odom_beat& beat, const std::string& source);

/// Reads the beat.csv of a recording (docs/recording.md). Throws std::invalid_argument with file,
/// line and column if it is not usable.
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
