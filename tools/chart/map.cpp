#include "tools/chart/chart.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "tools/chart/picture.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools::chart {
namespace {

bool is_line(const PlotSeries& series) {
  return series.mark == Mark::line && !series.points.empty();
}

}  // namespace

View view_of(const Chart& map) {
  constexpr double smallest = 0.2;  // m
  constexpr double margin = 0.06;   // of the size
  const auto main = std::ranges::find_if(map.series, is_line);
  if (main == map.series.end()) return {};
  const Point& start = main->points.front();
  View view{{start.x, start.x}, {start.y, start.y}};
  for (const Point& p : main->points) {
    view.x.take(p.x);
    view.y.take(p.y);
  }
  const double size = std::max({view.x.width(), view.y.width(), smallest});
  const View reach{view.x.grown(0.5 * size), view.y.grown(0.5 * size)};
  for (const PlotSeries& series : map.series) {
    if (!is_line(series)) continue;
    for (const Point& p : series.points) {
      view.x.take(std::clamp(p.x, reach.x.low, reach.x.high));
      view.y.take(std::clamp(p.y, reach.y.low, reach.y.high));
    }
  }
  return {view.x.grown(margin * size), view.y.grown(margin * size)};
}

Axes map_axes(const View& view, double top) {
  constexpr double tallest = 1.3 * canvas;  // a tall track may be a third higher than wide
  constexpr double flattest = 0.3;          // least height / width of the plot
  // The same step for both axes gives squares.
  const double step = round_step(std::max(view.x.width(), view.y.width()), 8.0);
  const auto letters = [step](double value) { return width(number(value, decimals_for(step))); };
  const auto longest = static_cast<double>(std::max(letters(view.y.low), letters(view.y.high)));
  const double left = border + std::max(60.0, letter_width * tick_size * longest + 16.0);
  const double right = canvas - border - 12.0;
  const double scale = std::min((right - left) / view.x.width(), tallest / view.y.width());
  const double wide = (right - left) / scale;
  const Range x = view.x.grown(0.5 * (wide - view.x.width()));
  const Range y = view.y.grown(0.5 * std::max(0.0, flattest * wide - view.y.width()));
  const auto ticks_of = [step](const Range& range) {
    return ticks(range, Scaling::linear, range.width() / step * (1.0 + 1e-9));
  };
  return {{x, Scaling::linear, left, right},
          {y, Scaling::linear, top + y.width() * scale, top},
          ticks_of(x),
          ticks_of(y)};
}

std::vector<Point> spaced(std::span<const Point> points, const Axes& axes, double distance) {
  std::vector<Point> kept;
  Point before{-canvas, -canvas};
  for (const Point& p : points) {
    const Point at{axes.x(p.x), axes.y(p.y)};
    const bool is_last = &p == &points.back();
    if (!is_last && std::hypot(at.x - before.x, at.y - before.y) < distance) continue;
    kept.push_back(p);
    before = at;
  }
  return kept;
}

std::string draw_ellipse(const Ellipse& ellipse, const Axes& axes) {
  // Axes of the covariance: λ = (a + c)/2 ± √(((a − c)/2)² + b²), turned by ½ atan2(2b, a − c).
  const auto [a, b, c] = ellipse.covariance;
  const double mean = 0.5 * (a + c);
  const double difference = std::hypot(0.5 * (a - c), b);
  const double scale = (axes.x.to - axes.x.from) / axes.x.range.width();
  const double major = 3.0 * std::sqrt(std::max(0.0, mean + difference)) * scale;
  const double minor = 3.0 * std::sqrt(std::max(0.0, mean - difference)) * scale;
  constexpr double largest = 0.4 * canvas;
  if (!(major > 1.0) || major > largest) return {};
  const double turn = -0.5 * std::atan2(2.0 * b, a - c) * 180.0 / std::numbers::pi;
  return fmt::format(
      R"svg(<ellipse rx="{0}" ry="{1}" transform="translate({2} {3}) rotate({4})" fill="{5}" )svg"
      R"svg(fill-opacity="0.10" stroke="{5}" stroke-width="2" stroke-dasharray="7 6"/>
)svg",
      svg::px(major), svg::px(minor), svg::px(axes.x(ellipse.centre.x)),
      svg::px(axes.y(ellipse.centre.y)), svg::px(turn), ellipse.colour);
}

std::string draw_ends(const std::vector<PlotSeries>& lines, const Axes& axes) {
  std::string ends;
  const auto mark = [&](const Point& at, double radius, const std::string& fill,
                        const std::string& stroke) {
    ends += svg::disc(axes.x(at.x), axes.y(at.y), radius, fill, stroke, 3.0);
  };
  for (const PlotSeries& series : lines)
    if (is_line(series))
      mark(series.points.back(), 7.0 + 0.7 * series.stroke, series.colour, "#FFFFFF");
  const auto main = std::ranges::find_if(lines, is_line);
  if (main != lines.end()) mark(main->points.front(), 12.0, "#FFFFFF", ink);
  return ends;
}

}  // namespace odomd::tools::chart
