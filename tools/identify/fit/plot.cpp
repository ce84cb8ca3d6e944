// The residuals of a fit over time, by source.
#include <algorithm>
#include <string>
#include <vector>

#include "tools/chart/chart.hpp"
#include "tools/chart/drawing.hpp"
#include "tools/chart/style.hpp"
#include "tools/identify/fit/findings.hpp"

namespace odomd::tools::fitting {
namespace {

constexpr double scatter_shown = 3.0;  // of the levels, in standard deviations

std::string axis_of(const std::string& source) {
  if (source == "position") return "position [m]";
  if (source == "yaw") return "yaw [rad]";
  if (source == "yaw_rate") return "yaw rate [rad/s]";
  if (source.starts_with("accel")) return source + " [m/s²]";
  return source + " [m/s]";
}

}  // namespace

void plot_residuals(const std::string& file, std::span<const Drive> drives, const Result& result) {
  std::vector<chart::Drawing> drawings;
  for (std::size_t kind = 0; kind < result.sources.size(); ++kind) {
    const SourceFit& source = result.sources[kind];
    if (source.count == 0) continue;
    chart::Chart picture{
        .title = "Residuals: " + source.name,
        .x = {.label = "time [s]"},
        .y = {.label = axis_of(source.name)},
        .levels = {{scatter_shown * source.found, "3 sigma"}, {-scatter_shown * source.found, ""}}};
    picture.height = 260.0;
    for (std::size_t drive = 0; drive < drives.size(); ++drive) {
      chart::Series series{.label = drives.size() > 1 ? drives[drive].name : "",
                           .colour = chart::colour_of(drive),
                           .mark = chart::Mark::dots};
      for (const ResidualPoint& point : result.residuals)
        if (point.drive == drive && point.kind == kind)
          series.points.push_back({point.t, point.residual});
      std::ranges::stable_sort(series.points, {}, &chart::Point::x);
      picture.series.push_back(std::move(series));
    }
    drawings.push_back(chart::draw(picture));
  }
  chart::write_picture(file, drawings);
}

}  // namespace odomd::tools::fitting
