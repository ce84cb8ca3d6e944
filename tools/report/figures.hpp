// The charts of an evaluated drive and of other files: errors and innovations over time, the timing
// of ticks, and the map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/chart/chart.hpp"
#include "tools/chart/picture.hpp"
#include "tools/drive_files/beat_histogram.hpp"
#include "tools/evaluation/evaluated_drive.hpp"
#include "tools/math/se2.hpp"

namespace odomd::tools {

struct Figure {
  chart::Drawing drawing;
  std::string caption;  ///< describes the drawing in one or two sentences
};

[[nodiscard]] inline double seconds_after(std::int64_t zero_ns, std::int64_t t_ns) {
  return static_cast<double>(t_ns - zero_ns) * 1e-9;
}

/// A chart over time, without curves.
[[nodiscard]] chart::Chart time_chart(std::string title, std::string y_label);

/// `series` with the value of every row that has one.
template <typename Rows, typename Value>
[[nodiscard]] chart::PlotSeries over_time(chart::PlotSeries series, const Rows& rows,
                                          std::int64_t zero_ns, const Value& value) {
  for (const auto& row : rows)
    if (const std::optional<double> y = value(row))
      series.points.push_back({seconds_after(zero_ns, row.t_ns), *y});
  return series;
}

/// A map without trajectories.
[[nodiscard]] chart::Chart empty_map(const std::string& title);

/// Wake-up latency, and the execution time of a tick if it was measured. Both axes are logarithmic,
/// so that one late tick in a million is visible. Captions: median, 99 %, largest.
[[nodiscard]] std::vector<Figure> beat_charts(const BeatHistogram& beat);

/// A chart for every dimension of every tested source, in the order of the sources: ν as dots,
/// gated ones in another colour, and the band ±3√S. Times are seconds after `zero_ns`.
[[nodiscard]] std::vector<chart::Chart> innovation_charts(
    std::span<const estimator::Judgement> judgements, std::int64_t zero_ns);

/// Reference and aligned estimates within their common time, camera poses as dots; cm/m and heading
/// error in the legend.
[[nodiscard]] chart::Chart evaluation_map(const EvaluatedDrive& drive, const std::string& title);
[[nodiscard]] Figure map_figure(const EvaluatedDrive& drive);

/// Index of the estimate that is shown in detail: the last whose samples were tested, otherwise the
/// last with a covariance, otherwise the last.
[[nodiscard]] std::size_t focus_of(const EvaluatedDrive& drive);

/// Figures for a drive with a reference; otherwise none. Error over horizon (not with a camera as
/// reference); position and heading error of all estimates over time; along, cross and heading
/// error of the focus with three sigmas, and its NEES.
[[nodiscard]] std::vector<Figure> error_figures(const EvaluatedDrive& drive);

/// Errors over the mean speed of each drive, one curve per model: 35 ms, end per metre, heading at
/// the end. Figures that no drive has are left out.
[[nodiscard]] std::vector<chart::Drawing> errors_by_speed(
    const std::vector<EvaluatedDrive>& drives);

/// For the focus, one figure per source whose samples were tested; three for the camera.
[[nodiscard]] std::vector<Figure> innovation_figures(const EvaluatedDrive& drive);

}  // namespace odomd::tools
