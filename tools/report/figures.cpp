#include "tools/report/figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "tools/cli/text.hpp"
#include "tools/evaluation/pose_error.hpp"

namespace odomd::tools {
namespace {

using chart::Chart;
using chart::PlotSeries;

// The unit of lengths in a chart: millimetres if all values are below 0.2 m.
struct Unit {
  const char* name;
  double factor;
};
Unit unit_for(double largest_m) {
  return largest_m < 0.2 ? Unit{"mm", 1e3} : Unit{"m", 1.0};
}

Figure horizon(const EvaluatedDrive& drive) {
  const auto names = names_of(drive);
  const auto colours = colours_of(drive);
  Chart chart;
  chart.height = 560.0;
  chart.x = {"horizon [ms]", chart::Scaling::logarithmic, chart::Range{4.5, 1100.0}};
  chart.y = {"mean error of the predicted displacement [mm]", chart::Scaling::logarithmic, {}};
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    PlotSeries series{names[i], "", colours[i], {}, chart::Mark::line_and_dots};
    for (const HorizonError& e : drive.report.evaluations[i].horizons)
      series.points.push_back(
          {static_cast<double>(e.horizon_ns) * 1e-6, std::max(1e3 * e.displacement.mean, 1e-4)});
    if (const auto* const at = error_over(drive.report.evaluations[i], short_horizon_ns))
      series.note = fixed(1e3 * at->displacement.mean, 2) + " mm at 35 ms";
    chart.series.push_back(std::move(series));
  }
  return {draw(chart),
          "Error over horizon: error of the displacement over the next 5 ms to 1 s, in the body "
          "frame. Both axes are logarithmic."};
}

using Errors = std::vector<std::vector<PoseError>>;  // one vector per estimate

// Plots one value of each error over time; errors that lack it are left out.
template <typename Value>
PlotSeries series_of(const EvaluatedDrive& drive, std::size_t estimate,
                     const std::vector<PoseError>& errors, Value value) {
  return over_time({names_of(drive)[estimate], "", colours_of(drive)[estimate], {}}, errors,
                   drive.report.evaluations.front().first_ns, value);
}

Figure position_errors(const EvaluatedDrive& drive, const Errors& errors) {
  double largest = 0.0;
  for (const Evaluation& e : drive.report.evaluations) largest = std::max(largest, e.position.max);
  const Unit unit = unit_for(largest);
  Chart chart = time_chart("", std::string{"position error ["} + unit.name + "]");
  for (std::size_t i = 0; i < errors.size(); ++i) {
    chart.series.push_back(series_of(drive, i, errors[i], [&](const PoseError& e) {
      return std::hypot(e.error.x, e.error.y) * unit.factor;
    }));
    chart.series.back().note =
        "rms " + fixed(drive.report.evaluations[i].position.rms * unit.factor, 2);
  }
  return {draw(chart), "Distance of each estimate from the reference."};
}

Figure heading_errors(const EvaluatedDrive& drive, const Errors& errors) {
  Chart chart = time_chart("", "heading error [deg]");
  for (std::size_t i = 0; i < errors.size(); ++i) {
    chart.series.push_back(
        series_of(drive, i, errors[i], [](const PoseError& e) { return e.error.yaw * degrees; }));
    chart.series.back().note = "end " + fixed(drive.report.evaluations[i].heading_end * degrees, 2);
  }
  return {draw(chart), "Accumulated heading error of each estimate."};
}

// An error component of the estimate shown in detail (focus_of), and its sigma.
struct Component {
  const char* name;
  double DrivenError::*value;
  double DrivenError::*sigma;
};

Figure with_band(const EvaluatedDrive& drive, const std::vector<PoseError>& errors,
                 std::size_t estimate, const Component& component) {
  Chart chart = time_chart("", "");
  chart.series = {series_of(drive, estimate, errors,
                            [&](const PoseError& e) { return driven(e).*component.value; })};
  PlotSeries& series = chart.series.front();
  chart::Band band{"±3σ", series.colour, {}};
  double largest = 0.0;
  std::size_t inside = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double reach = 3.0 * driven(errors[i]).*component.sigma;
    const auto& [x, y] = series.points[i];
    band.points.push_back({x, -reach, reach});
    largest = std::max(largest, std::abs(y));
    if (std::abs(y) <= reach) ++inside;
  }
  const bool angle = component.value == &DrivenError::yaw;
  const Unit unit = angle ? Unit{"deg", degrees} : unit_for(largest);
  for (auto& point : series.points) point.y *= unit.factor;
  for (auto& [x, low, high] : band.points) high = -(low *= unit.factor);
  chart.y.label = std::string{component.name} + " [" + unit.name + "]";
  if (drive.report.evaluations[estimate].consistency) {
    const double share = static_cast<double>(inside) / static_cast<double>(errors.size());
    series.note = fixed(100.0 * share, 1) + " % inside 3σ";
    chart.bands = {std::move(band)};
  }
  return {draw(chart), ""};
}

Figure nees(const EvaluatedDrive& drive, const std::vector<PoseError>& errors,
            std::size_t estimate) {
  Chart chart = time_chart("", "NEES of (x, y, yaw)");
  chart.y.scaling = chart::Scaling::logarithmic;
  chart.levels = {{3.0, "3, expected"}, {chi_squared_95_of_3, ""}};
  double largest = 10.0;
  PlotSeries series =
      series_of(drive, estimate, errors, [&](const PoseError& e) -> std::optional<double> {
        if (!e.nees) return std::nullopt;
        largest = std::max(largest, *e.nees);
        return std::max(*e.nees, 1e-3);
      });
  const Consistency& consistency = *drive.report.evaluations[estimate].consistency;
  series.note = "mean " + fixed(consistency.nees, 2) + " · " +
                fixed(100.0 * consistency.inside_95, 1) + " % below χ²₉₅";
  chart.y.range = chart::Range{0.01, 1.5 * largest};
  chart.series = {std::move(series)};
  return {draw(chart),
          "Squared error over the filter's own covariance. The upper line is χ²₉₅ of three degrees "
          "of freedom: a consistent filter is below it for 95 % of the time."};
}

}  // namespace

std::size_t focus_of(const EvaluatedDrive& drive) {
  for (std::size_t i = drive.replays.size(); i-- > 0;)
    if (!drive.replays[i].judgements.empty()) return i;
  for (std::size_t i = drive.estimates.size(); i-- > 0;)
    if (drive.estimates[i].has_covariance) return i;
  return drive.estimates.size() - 1;
}

Figure map_figure(const EvaluatedDrive& drive) {
  std::string caption = drive.reference ? "Reference and estimates" : "The estimates";
  caption += ": start hollow, ends filled, end error per metre and heading in the legend";
  if (!drive.cameras.empty()) caption += "; the dots are poses of the camera";
  const auto states_sigma = [](const Evaluation& one) { return one.consistency.has_value(); };
  caption += std::ranges::any_of(drive.report.evaluations, states_sigma)
                 ? "; the dashed ellipse is the filter's own 3σ at the end."
                 : ".";
  return {draw(evaluation_map(drive, "")), caption};
}

std::vector<Figure> error_figures(const EvaluatedDrive& drive) {
  if (!drive.reference) return {};
  Errors all;
  for (std::size_t i = 0; i < drive.estimates.size(); ++i) {
    all.push_back(pose_errors(common_times(*drive.reference, drive.estimates[i]),
                              drive.report.evaluations[i].alignment,
                              drive.report.evaluations[i].consistency.has_value()));
  }
  std::vector<Figure> figures{position_errors(drive, all), heading_errors(drive, all)};
  // With a camera reference, no error over less than a second is known.
  if (!drive.reference->is_camera) figures.insert(figures.begin(), horizon(drive));
  static constexpr std::array<Component, 3> components{{
      {"error along", &DrivenError::along, &DrivenError::sigma_along},
      {"error across", &DrivenError::cross, &DrivenError::sigma_cross},
      {"heading error", &DrivenError::yaw, &DrivenError::sigma_yaw},
  }};
  const std::size_t focus = focus_of(drive);
  for (const Component& component : components) {
    figures.push_back(with_band(drive, all[focus], focus, component));
  }
  const std::size_t heading = figures.size() - 1;
  const std::string name = names_of(drive)[focus];
  figures[heading - 2].caption = name + " is ahead of the reference (positive) or behind it.";
  figures[heading - 1].caption = name + " is to its left (positive) or to its right.";
  if (drive.report.evaluations[focus].consistency) {
    figures[heading].caption = "Heading of " + name + " with its own three standard deviations.";
    figures.push_back(nees(drive, all[focus], focus));
  } else if (drive.estimates[focus].has_covariance) {
    figures[heading].caption =
        "Without the filter's standard deviations: they include the uncertainty of its start, "
        "which the alignment removes.";
  }
  return figures;
}

std::vector<Figure> innovation_figures(const EvaluatedDrive& drive) {
  const std::size_t focus = focus_of(drive);
  if (focus >= drive.replays.size()) return {};
  const Evaluation& judged = drive.report.evaluations[focus];
  std::vector<estimator::Judgement> judgements;  // within the evaluated part
  std::ranges::copy_if(drive.replays[focus].judgements, std::back_inserter(judgements),
                       [&judged](const estimator::Judgement& one) {
                         return one.time_ns >= judged.first_ns && one.time_ns <= judged.last_ns;
                       });
  std::vector<Figure> figures;
  for (const Chart& chart :
       innovation_charts(judgements, drive.report.evaluations.front().first_ns)) {
    figures.push_back({draw(chart), ""});
  }
  return figures;
}

std::vector<chart::Drawing> errors_by_speed(const std::vector<EvaluatedDrive>& drives) {
  constexpr std::array<std::string_view, 3> quantities{"35 ms error mean [mm]", "end error [cm/m]",
                                                       "heading error at the end [deg]"};
  std::vector<chart::Drawing> drawings;
  for (const std::string_view label : quantities) {
    const Metric& quantity = metric(label);
    Chart chart;
    chart.x.label = "mean speed [m/s]";
    chart.y = {std::string{label}, chart::Scaling::logarithmic, {}};
    for (const EvaluatedDrive& drive : drives) {
      const auto names = names_of(drive), colours = colours_of(drive);
      for (std::size_t i = 0; i < names.size(); ++i) {
        const Evaluation& e = drive.report.evaluations[i];
        const Metric::Value value = quantity.value(e, e);
        const double duration = 1e-9 * static_cast<double>(e.last_ns - e.first_ns);
        if (!value || !(duration > 0.0)) continue;
        auto series = std::ranges::find(chart.series, names[i], &PlotSeries::label);
        if (series == chart.series.end())
          series = chart.series.insert(series,
                                       {names[i], "", colours[i], {}, chart::Mark::line_and_dots});
        series->points.push_back({e.path_length / duration, std::fabs(*value)});
      }
    }
    if (chart.series.empty()) continue;
    chart::Range speeds{chart.series[0].points[0].x, chart.series[0].points[0].x};
    for (PlotSeries& series : chart.series) {
      std::ranges::sort(series.points, {}, &chart::Point::x);
      speeds.take(series.points.front().x);
      speeds.take(series.points.back().x);
    }
    chart.x.range = with_room(speeds, chart::Scaling::linear);
    drawings.push_back(draw(chart));
  }
  return drawings;
}

}  // namespace odomd::tools
