#include "tools/report/plot_charts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "daemon/core/record.hpp"
#include "tools/chart/chart.hpp"
#include "tools/chart/map.hpp"
#include "tools/chart/style.hpp"
#include "tools/evaluation/evaluation_report.hpp"

namespace odomd::tools {
namespace {

using chart::Chart;
using chart::Series;

constexpr double degrees = 180.0 / std::numbers::pi;

// Columns beyond the trajectory's, in the order of plot_columns().
constexpr std::size_t steering_column = 0;
constexpr std::size_t accel_x_column = 1;
constexpr std::size_t accel_y_column = 2;
constexpr std::size_t calibration_column = 3;

// The tracks with their names, colours and starts; the reference first, where there is one.
struct Drawn {
  const Track* track;
  std::string name;
  std::string colour;
  double stroke;
  std::int64_t zero_ns;
};

std::vector<Drawn> drawn(const PlotInput& input) {
  std::vector<Drawn> all;
  std::vector<std::string> files;
  for (const Track& track : input.tracks) files.push_back(track.trajectory.name);
  const auto names = short_names(files);
  if (input.reference) {
    all.push_back({&*input.reference, "reference", chart::reference_colour, 7.0, 0});
  }
  for (std::size_t i = 0; i < input.tracks.size(); ++i) {
    all.push_back({&input.tracks[i], names[i], chart::colour_of(i), 3.0, 0});
  }
  std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
  for (Drawn& one : all) {
    one.zero_ns = one.track->trajectory.points.front().t_ns;
    first_ns = std::min(first_ns, one.zero_ns);
  }
  if (overlap(input)) {
    for (Drawn& one : all) one.zero_ns = first_ns;
  }
  return all;
}

double seconds(const Drawn& one, std::int64_t t_ns) {
  return static_cast<double>(t_ns - one.zero_ns) * 1e-9;
}

Chart over_time(const std::string& title, const std::string& y_label) {
  Chart chart;
  chart.title = title;
  chart.x.label = "time [s]";
  chart.y.label = y_label;
  return chart;
}

[[noreturn]] void nothing_to_draw(const PlotInput& input, const std::string& what) {
  throw std::invalid_argument(input.tracks.front().trajectory.name + ": has no " + what +
                              "; use a file of odom replay");
}

using Value = std::function<double(const TrajectoryPoint&)>;

// Of the tracks that have it.
Chart of_points(const std::vector<Drawn>& tracks, const std::string& title,
                const std::string& y_label, bool Trajectory::*needs, const Value& value) {
  Chart chart = over_time(title, y_label);
  for (const Drawn& one : tracks) {
    if (needs != nullptr && !(one.track->trajectory.*needs)) continue;
    Series series{one.name, "", one.colour, {}, chart::Mark::line, one.stroke};
    for (const TrajectoryPoint& point : one.track->trajectory.points) {
      series.points.push_back({seconds(one, point.t_ns), value(point)});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart of_column(const std::vector<Drawn>& tracks, const std::string& title,
                const std::string& y_label, std::size_t column, double factor) {
  Chart chart = over_time(title, y_label);
  for (const Drawn& one : tracks) {
    const auto& values = one.track->columns.at(column);
    if (values.empty()) continue;
    Series series{one.name, "", one.colour, {}, chart::Mark::line, one.stroke};
    for (std::size_t i = 0; i < values.size(); ++i) {
      series.points.push_back({seconds(one, one.track->times_ns[i]), values[i] * factor});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

chart::Drawing map_of(const PlotInput& input) {
  chart::Map map;
  const auto points_of = [](const Track& track) {
    std::vector<chart::Point> points;
    for (const TrajectoryPoint& p : track.trajectory.points) {
      points.push_back({p.pose.x, p.pose.y});
    }
    return points;
  };
  for (const Drawn& one : drawn(input)) {
    chart::Trace trace{one.name, "", points_of(*one.track), {}, one.colour};
    if (input.reference && one.track == &*input.reference) {
      map.reference = std::move(trace);
    } else {
      map.estimates.push_back(std::move(trace));
    }
  }
  return draw(map);
}

std::vector<Chart> sigmas(const std::vector<Drawn>& tracks) {
  const auto root = [](std::size_t variance, double factor) {
    return [variance, factor](const TrajectoryPoint& p) {
      return factor * std::sqrt(std::max(p.covariance[variance], 0.0));
    };
  };
  const auto chart = [&](const char* title, const char* label, const Value& value) {
    Chart one = of_points(tracks, title, label, &Trajectory::has_covariance, value);
    one.y.scaling = chart::Scaling::logarithmic;
    return one;
  };
  return {chart("Standard deviation of x", "sigma_x [mm]", root(0, 1e3)),
          chart("Standard deviation of y", "sigma_y [mm]", root(3, 1e3)),
          chart("Standard deviation of the heading", "sigma_yaw [deg]", root(5, degrees))};
}

std::vector<Chart> calibrations(const std::vector<Drawn>& tracks) {
  struct Unit {
    const char* label;
    double factor;
  };
  static constexpr std::array<Unit, daemon::calibrations.size()> units{{{"deg/s", degrees},
                                                                        {"1: exact", 1.0},
                                                                        {"m/s²", 1.0},
                                                                        {"m/s²", 1.0},
                                                                        {"1: exact", 1.0},
                                                                        {"deg", degrees},
                                                                        {"1: as configured", 1.0},
                                                                        {"ms", 1e3},
                                                                        {"ms", 1e3},
                                                                        {"ms", 1e3},
                                                                        {"m/s²", 1.0}}};
  std::vector<Chart> charts;
  for (std::size_t i = 0; i < units.size(); ++i) {
    const std::string name{daemon::calibrations[i].name};
    charts.push_back(
        of_column(tracks, name, units[i].label, calibration_column + i, units[i].factor));
    charts.back().height = 300.0;
  }
  return charts;
}

std::vector<Chart> charts_of(Quantity quantity, const std::vector<Drawn>& tracks) {
  switch (quantity) {
    case Quantity::speed:
      return {of_points(tracks, "Speed", "v_x [m/s]", &Trajectory::has_motion,
                        [](const auto& p) { return p.motion.vx; })};
    case Quantity::lateral_speed:
      return {of_points(tracks, "Lateral speed", "v_y [m/s]", &Trajectory::has_motion,
                        [](const auto& p) { return p.motion.vy; })};
    case Quantity::yaw_rate:
      return {of_points(tracks, "Yaw rate", "yaw rate [deg/s]", &Trajectory::has_motion,
                        [](const auto& p) { return p.motion.yaw_rate * degrees; })};
    case Quantity::heading:
      return {of_points(tracks, "Heading", "yaw, unwrapped [deg]", nullptr,
                        [](const auto& p) { return p.pose.yaw * degrees; })};
    case Quantity::steering:
      return {of_column(tracks, "Steering", "at the front wheels [deg]", steering_column, degrees)};
    case Quantity::acceleration:
      return {of_column(tracks, "Acceleration along x", "accel_x [m/s²]", accel_x_column, 1.0),
              of_column(tracks, "Acceleration along y", "accel_y [m/s²]", accel_y_column, 1.0)};
    case Quantity::sigma:
      return sigmas(tracks);
    case Quantity::calibrations:
      return calibrations(tracks);
    case Quantity::trajectory:
      break;
  }
  return {};
}

const char* columns_for(Quantity quantity) {
  switch (quantity) {
    case Quantity::speed:
    case Quantity::lateral_speed:
    case Quantity::yaw_rate:
      return R"(columns "vx", "vy", "yaw_rate")";
    case Quantity::steering:
      return R"(column "steering")";
    case Quantity::acceleration:
      return R"(columns "accel_x", "accel_y")";
    case Quantity::sigma:
      return R"(columns "sigma_x", "sigma_y", "sigma_yaw" of the map's pose)";
    case Quantity::calibrations:
      return R"(calibrations (column "gyro_bias", ...))";
    default:
      return "rows";
  }
}

}  // namespace

std::vector<std::string> plot_columns() {
  std::vector<std::string> names{"steering", "accel_x", "accel_y"};
  for (const auto& calibration : daemon::calibrations) names.emplace_back(calibration.name);
  return names;
}

bool overlap(const PlotInput& input) {
  std::int64_t latest_start = std::numeric_limits<std::int64_t>::min();
  std::int64_t earliest_end = std::numeric_limits<std::int64_t>::max();
  const auto take = [&](const Track& track) {
    latest_start = std::max(latest_start, track.trajectory.points.front().t_ns);
    earliest_end = std::min(earliest_end, track.trajectory.points.back().t_ns);
  };
  if (input.reference) take(*input.reference);
  for (const Track& track : input.tracks) take(track);
  return latest_start <= earliest_end;
}

std::vector<chart::Drawing> plot(Quantity quantity, const PlotInput& input) {
  if (quantity == Quantity::trajectory) return {map_of(input)};
  std::vector<chart::Drawing> drawings;
  for (const Chart& chart : charts_of(quantity, drawn(input))) {
    // A reference alone is no picture of the poses.
    const auto is_reference = [](const Series& series) {
      return series.colour == chart::reference_colour;
    };
    if (!std::ranges::all_of(chart.series, is_reference)) drawings.push_back(draw(chart));
  }
  if (drawings.empty()) nothing_to_draw(input, columns_for(quantity));
  return drawings;
}

}  // namespace odomd::tools
