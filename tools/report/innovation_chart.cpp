#include "tools/report/innovation_chart.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "tools/chart/style.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using estimator::Judgement;
using estimator::Source;

struct Dimension {
  const char* name;
  const char* unit;
  double factor;  // from the source's unit
};

constexpr double degrees = 180.0 / std::numbers::pi;

std::vector<Dimension> dimensions_of(Source source) {
  switch (source) {
    case Source::yaw_rate:
      return {{"", "deg/s", degrees}};
    case Source::accel_x:
    case Source::accel_y:
      return {{"", "m/s²", 1.0}};
    case Source::camera:
      return {{" x", "mm", 1e3}, {" y", "mm", 1e3}, {" yaw", "deg", degrees}};
    default:
      return {{"", "m/s", 1.0}};
  }
}

// [s]: five times the usual spacing, and half a second at least.
double longest_spacing(std::span<const Judgement> samples) {
  std::vector<std::int64_t> spacings;
  for (std::size_t i = 1; i < samples.size(); ++i)
    spacings.push_back(samples[i].time_ns - samples[i - 1].time_ns);
  if (spacings.empty()) return 0.0;
  return std::max(5e-9 * static_cast<double>(median_of(std::move(spacings))), 0.5);
}

chart::Chart chart_of(std::span<const Judgement> samples, std::size_t dimension,
                      const Dimension& words, std::int64_t zero_ns) {
  chart::Chart chart;
  chart.height = 400.0;
  chart.title =
      std::string{estimator::source_names.at(static_cast<std::size_t>(samples.front().source))} +
      words.name;
  chart.x.label = "time [s]";
  chart.y.label = std::string{"innovation ["} + words.unit + "]";
  chart::Series taken{"", "", chart::colour_of(0), {}, chart::Mark::dots};
  chart::Series gated{"gated", "", chart::refused_colour, {}, chart::Mark::dots};
  chart::Band band{"±3√S", chart::colour_of(0), {}};
  // No expected range is drawn over a stretch without samples.
  const double gap = longest_spacing(samples);
  constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
  for (const Judgement& sample : samples) {
    const double t = static_cast<double>(sample.time_ns - zero_ns) * 1e-9;
    const double nu = sample.innovation[dimension] * words.factor;
    const double reach = 3.0 * std::sqrt(sample.variance[dimension]) * words.factor;
    (sample.verdict == estimator::Verdict::gated ? gated : taken).points.push_back({t, nu});
    if (!band.points.empty() && t - band.points.back().x > gap)
      band.points.push_back({0.5 * (t + band.points.back().x), nowhere, nowhere});
    band.points.push_back({t, -reach, reach});
  }
  if (gated.points.empty()) gated.label.clear();
  chart.bands = {std::move(band)};
  chart.series = {std::move(taken), std::move(gated)};
  return chart;
}

}  // namespace

std::vector<chart::Chart> innovation_charts(std::span<const Judgement> judgements,
                                            std::int64_t zero_ns) {
  std::array<std::vector<Judgement>, estimator::source_count> by_source;
  for (const Judgement& judgement : judgements) {
    // The pose that initialises the filter is not tested.
    if (judgement.degrees < 1 || !(judgement.variance[0] > 0.0)) continue;
    by_source.at(static_cast<std::size_t>(judgement.source)).push_back(judgement);
  }
  // One axis of time for all: a source that is tested for a while only is seen to be.
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (const auto& samples : by_source) {
    for (const Judgement& sample : samples) {
      const double t = static_cast<double>(sample.time_ns - zero_ns) * 1e-9;
      first = std::min(first, t);
      last = std::max(last, t);
    }
  }
  std::vector<chart::Chart> charts;
  for (auto& samples : by_source) {
    if (samples.empty()) continue;
    std::ranges::stable_sort(samples, {}, &Judgement::time_ns);
    const auto dimensions = dimensions_of(samples.front().source);
    for (std::size_t i = 0; i < dimensions.size(); ++i) {
      charts.push_back(chart_of(samples, i, dimensions[i], zero_ns));
      if (first < last) charts.back().x.range = chart::Range{first, last};
    }
  }
  return charts;
}

}  // namespace odomd::tools
