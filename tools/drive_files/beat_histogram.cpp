#include "tools/drive_files/beat_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "tools/cli/files.hpp"
#include "tools/drive_files/table.hpp"

namespace odomd::tools {
namespace {

std::size_t bucket_of(std::int64_t ns) {
  const double us = static_cast<double>(ns) * 1e-3;
  if (us < 1.0) return 0;
  const auto bucket = 1 + static_cast<std::size_t>(std::floor(4.0 * std::log2(us) + 1e-9));
  return std::min<std::size_t>(bucket, ODOM_HISTOGRAM_BUCKETS - 1);
}

}  // namespace

BeatHistogram beat_histogram(const odom_beat& beat, const std::string& source) {
  BeatHistogram histogram;
  histogram.source = source;
  histogram.ticks = beat.ticks;
  histogram.missed = beat.missed;
  std::ranges::copy(beat.wakeup, histogram.wakeup.begin());
  std::ranges::copy(beat.execution, histogram.execution.begin());
  histogram.max_wakeup_ns = beat.max_wakeup_ns;
  histogram.max_execution_ns = beat.max_execution_ns;
  return histogram;
}

BeatHistogram read_beat_log(const std::filesystem::path& file) {
  auto input = open_input(file);
  CsvReader reader{input,
                   file.string(),
                   names_of<BeatRow>(beat_columns),
                   LastLine::drop_unended,
                   {.required = 3}};
  BeatHistogram histogram;
  histogram.source = file.string();
  BeatRow before;
  while (reader.next()) {
    const auto row = read_row<BeatRow>(reader, beat_columns);
    if (histogram.ticks > 0) {
      if (row.tick <= before.tick)
        reader.fail(0, "the tick number does not increase; sort the rows by tick");
      histogram.missed += row.tick - before.tick - 1;
    }
    before = row;
    const std::int64_t late_ns = row.woke_ns - row.time_ns;
    histogram.max_wakeup_ns = std::max(histogram.max_wakeup_ns, late_ns);
    ++histogram.wakeup[bucket_of(late_ns)];
    ++histogram.ticks;
  }
  if (histogram.ticks == 0) {
    throw std::invalid_argument(file.string() + ": has no rows");
  }
  return histogram;
}

BucketEdges edges_of(std::size_t bucket) {
  const auto i = static_cast<double>(bucket);
  return {bucket == 0 ? std::exp2(-0.25) : std::exp2(0.25 * (i - 1.0)), std::exp2(0.25 * i)};
}

double percentile_us(const BeatBuckets& buckets, double share, std::int64_t max_ns) {
  const auto total = std::accumulate(buckets.begin(), buckets.end(), std::uint64_t{0});
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total)));
  const double max_us = static_cast<double>(max_ns) * 1e-3;
  std::uint64_t sum = 0;
  for (std::size_t bucket = 0; bucket + 1 < buckets.size(); ++bucket) {
    sum += buckets[bucket];
    if (sum >= wanted) return std::min(max_us, edges_of(bucket).high_us);
  }
  return max_us;
}

}  // namespace odomd::tools
