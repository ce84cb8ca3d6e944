#include "tools/report/figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "tools/chart/chart.hpp"
#include "tools/chart/picture.hpp"
#include "tools/cli/text.hpp"
#include "tools/evaluation/evaluation_report.hpp"
#include "tools/math/median.hpp"

namespace odomd::tools {
namespace {

using chart::Chart;

Chart histogram_of(BeatBuckets buckets, const std::string& what) {
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

std::string percentiles(BeatBuckets buckets, std::int64_t max_ns) {
  return "Median " + fixed(percentile_us(buckets, 0.5, max_ns), 0) + " us, 99 % within " +
         fixed(percentile_us(buckets, 0.99, max_ns), 0) + " us, largest " +
         fixed(static_cast<double>(max_ns) * 1e-3, 0) + " us.";
}

using estimator::Judgement;
using estimator::Quantity;
using estimator::Source;

struct Dimension {
  const char* name;
  const char* unit;
  double factor;  // from the source's unit
};

std::vector<Dimension> dimensions_of(Source source) {
  switch (info_of(source).quantity) {
    case Quantity::yaw_rate:
      return {{"", "deg/s", degrees}};
    case Quantity::acceleration:
      return {{"", "m/s²", 1.0}};
    case Quantity::pose:
      return {{" x", "mm", 1e3}, {" y", "mm", 1e3}, {" yaw", "deg", degrees}};
    default:
      return {{"", "m/s", 1.0}};
  }
}

// Longest spacing of samples that is no gap [s]: five times the median, at least 0.5 s.
double longest_spacing(std::span<const Judgement> samples) {
  std::vector<std::int64_t> spacings;
  for (std::size_t i = 1; i < samples.size(); ++i)
    spacings.push_back(samples[i].time_ns - samples[i - 1].time_ns);
  if (spacings.empty()) return 0.0;
  return std::max(5e-9 * static_cast<double>(median_of(std::move(spacings))), 0.5);
}

Chart chart_of(std::span<const Judgement> samples, std::size_t dimension, const Dimension& words,
               std::int64_t zero_ns) {
  Chart chart = time_chart(
      std::string{estimator::source_names.at(static_cast<std::size_t>(samples.front().source))} +
          words.name,
      std::string{"innovation ["} + words.unit + "]");
  chart.height = 400.0;
  chart::PlotSeries taken{"", "", chart::colour_of(0), {}, chart::Mark::dots};
  chart::PlotSeries gated{"gated", "", chart::refused_colour, {}, chart::Mark::dots};
  chart::Band band{"±3√S", chart::colour_of(0), {}};
  // No expected range is drawn over a stretch without samples.
  const double gap = longest_spacing(samples);
  constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
  for (const Judgement& sample : samples) {
    const double t = seconds_after(zero_ns, sample.time_ns);
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

std::vector<chart::Point> points_between(const Trajectory& trajectory, std::int64_t first_ns,
                                         std::int64_t last_ns) {
  std::vector<chart::Point> points;
  for (const TrajectoryPoint& point : trajectory.points) {
    if (point.t_ns >= first_ns && point.t_ns <= last_ns) {
      points.push_back({point.pose.x, point.pose.y});
    }
  }
  return points;
}

std::string note_of(const Evaluation& e) {
  if (e.against == Against::nothing) return {};
  const double turned = std::abs(e.heading_end) * degrees;
  std::string heading = fixed(turned, turned < 1.0 ? 2 : 1) + "°";
  if (!e.end_cm_per_m) return heading;
  return fixed(*e.end_cm_per_m, *e.end_cm_per_m < 0.1 ? 3 : 2) + " cm/m · " + heading;
}

}  // namespace

Chart time_chart(std::string title, std::string y_label) {
  return {
      .title = std::move(title), .x = {.label = "time [s]"}, .y = {.label = std::move(y_label)}};
}

std::vector<Figure> beat_charts(const odom_beat& beat) {
  std::vector<Figure> charts{{draw(histogram_of(beat.wakeup, "Wake-up latency")),
                              percentiles(beat.wakeup, beat.max_wakeup_ns) + " " +
                                  counted(beat.ticks, "tick") + ", " + std::to_string(beat.missed) +
                                  " missed."}};
  const bool measured =
      std::ranges::any_of(beat.execution, [](std::uint64_t count) { return count > 0; });
  if (measured) {
    charts.push_back({draw(histogram_of(beat.execution, "Work in a tick")),
                      percentiles(beat.execution, beat.max_execution_ns)});
  }
  return charts;
}

std::vector<chart::Chart> innovation_charts(std::span<const Judgement> judgements,
                                            std::int64_t zero_ns) {
  std::array<std::vector<Judgement>, estimator::source_count> by_source;
  // All charts have one time axis, so that a source tested only part of the time stands out.
  constexpr double infinity = std::numeric_limits<double>::infinity();
  chart::Range all{infinity, -infinity};
  for (const Judgement& judgement : judgements) {
    // The pose that initialises the filter is not tested.
    if (judgement.degrees < 1 || !(judgement.variance[0] > 0.0)) continue;
    by_source.at(static_cast<std::size_t>(judgement.source)).push_back(judgement);
    all.take(seconds_after(zero_ns, judgement.time_ns));
  }
  std::vector<chart::Chart> charts;
  for (auto& samples : by_source) {
    if (samples.empty()) continue;
    std::ranges::stable_sort(samples, {}, &Judgement::time_ns);
    const auto dimensions = dimensions_of(samples.front().source);
    for (std::size_t i = 0; i < dimensions.size(); ++i) {
      charts.push_back(chart_of(samples, i, dimensions[i], zero_ns));
      if (all.low < all.high) charts.back().x.range = all;
    }
  }
  return charts;
}

chart::Chart empty_map(const std::string& title) {
  return {.title = title, .x = {.label = "x [m]"}, .y = {.label = "y [m]"}, .is_map = true};
}

chart::Chart evaluation_map(const EvaluatedDrive& drive, const std::string& title) {
  std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  double path = 0.0;
  for (const Evaluation& e : drive.report.evaluations) {
    first_ns = std::min(first_ns, e.first_ns);
    last_ns = std::max(last_ns, e.last_ns);
    path = std::max(path, e.path_length);
  }
  const auto names = names_of(drive);
  const auto colours = colours_of(drive);

  chart::Chart map = empty_map(title);
  if (drive.reference)
    map.series.push_back(
        {"reference", fixed(path, path < 1000.0 ? 1 : 0) + " m", chart::reference_colour,
         points_between(*drive.reference, first_ns, last_ns), chart::Mark::line, 9.0});
  const bool left_out = !drive.replays.empty() && !camera_came_in(drive);
  chart::PlotSeries cameras{
      left_out ? "camera, left out" : "camera", "", chart::dot_colour, {}, chart::Mark::dots};
  for (const auto& pose : drive.cameras)
    if (pose.capture_ns >= first_ns && pose.capture_ns <= last_ns)
      cameras.points.push_back({pose.x, pose.y});
  if (!cameras.points.empty()) map.series.push_back(std::move(cameras));
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    const Evaluation& e = drive.report.evaluations[i];
    const Trajectory moved = aligned(drive.estimates[i], e.alignment);
    map.series.push_back(
        {names[i], note_of(e), colours[i], points_between(moved, e.first_ns, e.last_ns)});
    if (!e.consistency) continue;
    const TrajectoryPoint end = *at(moved, e.last_ns);
    const auto& P = end.covariance;
    map.ellipses.push_back({{end.pose.x, end.pose.y}, {P[0], P[1], P[3]}, colours[i]});
  }
  return map;
}

}  // namespace odomd::tools
