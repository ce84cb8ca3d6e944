#include "tools/report/beat_chart.hpp"

#include <algorithm>

#include "tools/chart/chart.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools {
namespace {

using chart::Chart;

Chart histogram_of(const BeatBuckets& buckets, const std::string& what) {
  Chart chart;
  chart.title = what;
  chart.height = 400.0;
  chart.x = {"time [us]", chart::Scaling::logarithmic, {}};
  chart.y = {"ticks", chart::Scaling::logarithmic, {}};
  double most = 1.0;
  for (std::size_t i = 0; i < buckets.size(); ++i) {
    if (buckets[i] == 0) continue;
    const BucketEdges edges = edges_of(i);
    const auto height = static_cast<double>(buckets[i]);
    chart.bars.push_back({edges.low_us, edges.high_us, height});
    most = std::max(most, height);
  }
  chart.y.range = chart::Range{0.6, 2.0 * most};
  return chart;
}

std::string percentiles(const BeatBuckets& buckets, std::int64_t max_ns) {
  return "Median " + fixed(percentile_us(buckets, 0.5, max_ns), 0) + " us, 99 % within " +
         fixed(percentile_us(buckets, 0.99, max_ns), 0) + " us, largest " +
         fixed(static_cast<double>(max_ns) * 1e-3, 0) + " us.";
}

}  // namespace

std::vector<BeatChart> beat_charts(const BeatHistogram& beat) {
  std::vector<BeatChart> charts{{draw(histogram_of(beat.wakeup, "Wake-up latency")),
                                 percentiles(beat.wakeup, beat.max_wakeup_ns) + " " +
                                     counted(beat.ticks, "tick") + ", " +
                                     std::to_string(beat.missed) + " missed."}};
  const bool measured =
      std::ranges::any_of(beat.execution, [](std::uint64_t count) { return count > 0; });
  if (measured) {
    charts.push_back({draw(histogram_of(beat.execution, "Work in a tick")),
                      percentiles(beat.execution, beat.max_execution_ns)});
  }
  return charts;
}

}  // namespace odomd::tools
