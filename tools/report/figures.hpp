// The charts of an evaluated drive (errors and innovations over time, the timing of ticks, the
// map), and those of odom plot: of pose files and of the running daemon.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "estimator/common/measurement.hpp"
#include "tools/chart/chart.hpp"
#include "tools/chart/picture.hpp"
#include "tools/drive_files/drive_tables.hpp"
#include "tools/drive_files/trajectory.hpp"
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
[[nodiscard]] std::vector<Figure> beat_charts(const odom_beat& beat);

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

// Charts of pose files or of the running daemon, over time, and their trajectories.

struct LiveTrack {
  Trajectory track;
  odom_beat beat{};
};

/// Follows a running daemon for `seconds`, or until INT or TERM. The track has the columns of a
/// pose file. Throws like attach(), and std::runtime_error if no pose came.
[[nodiscard]] LiveTrack follow_daemon(const std::string& shm, double seconds, Frame frame,
                                      const std::vector<std::string>& further);

/// Values of calibrations by name, in SI units.
using Calibrations = std::map<std::string, double, std::less<>>;

/// The true calibrations of a simulated drive, from the plant.json in its folder, if there is a
/// single true value; none for other drives. Throws std::invalid_argument if the file is not of
/// odom sim.
[[nodiscard]] Calibrations true_calibrations(const std::filesystem::path& folder);

struct PlotInput {
  std::optional<Trajectory> reference;
  Calibrations truth;              ///< calibrations of the reference's drive
  std::vector<Trajectory> tracks;  ///< at least one; all with the columns of plot_columns()
};

/// The quantities that can be drawn: "trajectory", "speed", ...
[[nodiscard]] std::vector<std::string> plot_quantities();

/// The columns to read from pose files in addition to the trajectory.
[[nodiscard]] std::vector<std::string> plot_columns();

/// Times are seconds since the first row of all tracks, or of each track if they do not overlap.
/// Throws std::invalid_argument, naming file and column, if no track has the quantity.
[[nodiscard]] std::vector<chart::Drawing> plot(std::string_view quantity, const PlotInput& input);

/// Whether all tracks, including the reference, have times in common.
[[nodiscard]] bool overlap(const PlotInput& input);

}  // namespace odomd::tools
