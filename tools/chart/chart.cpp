#include "tools/chart/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "tools/chart/picture.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools::chart {
namespace {

using svg::px;

constexpr std::size_t columns = 480;  // of a thinned-out curve

// The smallest and the largest finite value (and, for a logarithmic axis, positive value).
class Extent {
 public:
  explicit Extent(Scaling scaling) : scaling_(scaling) {}
  void take(double value) {
    if (std::isfinite(value) && (scaling_ == Scaling::linear || value > 0.0)) range_.take(value);
  }
  [[nodiscard]] bool empty() const { return range_.low > range_.high; }
  [[nodiscard]] Range range() const {
    if (!empty()) return range_;
    return scaling_ == Scaling::logarithmic ? Range{0.1, 1.0} : Range{0.0, 1.0};
  }

 private:
  Scaling scaling_;
  Range range_{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
};

Range x_range(const Chart& chart) {
  if (chart.x.range) return *chart.x.range;
  Extent extent(chart.x.scaling);
  for (const auto& series : chart.series)
    for (const auto& p : series.points) extent.take(p.x);
  for (const auto& band : chart.bands)
    for (const auto& p : band.points) extent.take(p.x);
  for (const auto& bar : chart.bars) {
    extent.take(bar.low);
    extent.take(bar.high);
  }
  const Range range = extent.range();
  return range.width() > 0.0 ? range : with_room(range, chart.x.scaling);
}

// The value below which this share of all values lies.
double quantile(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Range y_range(const Chart& chart) {
  if (chart.y.range) return *chart.y.range;
  constexpr double near = 8.0;  // curve heights by which a band may extend the axis on either side
  constexpr double usual = 0.97;  // quantile of a band's edges that the axis includes
  Extent extent(chart.y.scaling);
  for (const auto& series : chart.series)
    for (const auto& p : series.points) extent.take(p.y);
  for (const auto& bar : chart.bars) extent.take(bar.height);
  for (const auto& level : chart.levels) extent.take(level.y);
  if (!chart.bars.empty() && chart.y.scaling == Scaling::linear) extent.take(0.0);
  const bool alone = extent.empty();
  const Range curves = extent.range();
  const double reach = near * std::max(curves.width(), 1e-12);
  for (const auto& band : chart.bands) {
    std::vector<double> low;
    std::vector<double> high;
    for (const auto& p : band.points) {
      if (std::isfinite(p.low)) low.push_back(p.low);
      if (std::isfinite(p.high)) high.push_back(p.high);
    }
    if (low.empty() || high.empty()) continue;
    const double bottom = quantile(std::move(low), 1.0 - usual);
    const double top = quantile(std::move(high), usual);
    extent.take(alone ? bottom : std::max(bottom, curves.low - reach));
    extent.take(alone ? top : std::min(top, curves.high + reach));
  }
  Range range = with_room(extent.range(), chart.y.scaling);
  if (!chart.bars.empty() && chart.y.scaling == Scaling::linear) range.low = 0.0;
  return range;
}

std::string path_of(const std::vector<Point>& points, const Scale& x, const Scale& y) {
  std::string data;
  bool pen_down = false;
  for (const Point& p : points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) {
      pen_down = false;
      continue;
    }
    data += fmt::format("{}{} {}", pen_down ? 'L' : 'M', px(x(p.x)), px(y(p.y)));
    pen_down = true;
  }
  return data;
}

// Many dots as one path: lines of zero length with round ends.
std::string dots_of(const std::vector<Point>& points, const Scale& x, const Scale& y,
                    const std::string& colour, double size) {
  std::string data;
  for (const Point& p : points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
    data += fmt::format("M{} {}h0", px(x(p.x)), px(y(p.y)));
  }
  return svg::line(data, colour, size);
}

std::string draw_on_map(const PlotSeries& series, const Axes& axes) {
  constexpr double step = 5.0, dot_spacing = 11.0;  // dots remain separate
  if (series.mark == Mark::line)
    return svg::line(path_of(spaced(series.points, axes, step), axes.x, axes.y), series.colour,
                     series.stroke);
  return dots_of(spaced(series.points, axes, dot_spacing), axes.x, axes.y, series.colour, 7.0);
}

std::string draw_series(const PlotSeries& series, const Scale& x, const Scale& y) {
  // Dots are wider than lines: fewer columns suffice.
  constexpr std::size_t columns_of_dots = 160;
  constexpr std::size_t dots_each = 12;
  const std::vector<Point> points = series.mark == Mark::dots
                                        ? thinned(series.points, x, columns_of_dots, dots_each)
                                        : decimated(series.points, x, columns);
  std::string out;
  if (series.mark == Mark::line || series.mark == Mark::line_and_dots)
    out += svg::line(path_of(points, x, y), series.colour, series.stroke);
  if (series.mark == Mark::dots) out += dots_of(points, x, y, series.colour, 4.5);
  if (series.mark == Mark::discs || series.mark == Mark::line_and_dots)
    out += dots_of(points, x, y, series.colour, 12.0);
  return out;
}

std::string draw_band(const Band& band, const Scale& x, const Scale& y) {
  const std::vector<BandPoint> points = decimated(band.points, x, columns);
  const auto is_gap = [](const BandPoint& p) {
    return !std::isfinite(p.low) || !std::isfinite(p.high);
  };
  std::string data;
  for (auto begin = points.begin(); begin != points.end();) {
    const auto end = std::find_if(begin, points.end(), is_gap);
    for (auto p = begin; p != end; ++p)
      data += fmt::format("{}{} {}", p == begin ? 'M' : 'L', px(x(p->x)), px(y(p->high)));
    for (auto p = end; p != begin; --p)
      data += fmt::format("L{} {}", px(x(std::prev(p)->x)), px(y(std::prev(p)->low)));
    if (begin != end) data += 'Z';
    begin = std::find_if_not(end, points.end(), is_gap);
  }
  if (data.empty()) return {};
  return fmt::format(
      R"(<path d="{}" fill="{}" fill-opacity="0.18" stroke="{}" stroke-opacity="0.45" stroke-width="1.5"/>)"
      "\n",
      data, band.colour, band.colour);
}

std::string draw_bars(const std::vector<Bar>& bars, const Scale& x, const Scale& y) {
  std::string data;
  for (const Bar& bar : bars) {
    if (!(bar.height > 0.0)) continue;
    data += fmt::format("M{} {}V{}H{}V{}Z", px(x(bar.low)), px(y.from), px(y(bar.height)),
                        px(x(bar.high)), px(y.from));
  }
  return fmt::format(R"(<path d="{}" fill="{}" stroke="#FFFFFF" stroke-width="1.5"/>)"
                     "\n",
                     data, colour_of(0));
}

std::vector<LegendEntry> entries_of(const Chart& chart) {
  std::vector<LegendEntry> entries;
  const View view = chart.is_map ? view_of(chart) : View{};
  const auto is_shown = [&view](const Point& p) { return view.holds(p); };
  for (const auto& series : chart.series) {
    if (series.label.empty()) continue;
    const bool line = series.mark == Mark::line || series.mark == Mark::line_and_dots;
    const bool leaves = chart.is_map && line && !std::ranges::all_of(series.points, is_shown);
    entries.push_back(
        {line ? line_mark(series.colour, series.stroke + 2.0) : dot_mark(series.colour),
         series.label, series.note + (leaves ? " · leaves the picture" : "")});
  }
  for (const auto& band : chart.bands) {
    if (!band.label.empty()) entries.push_back({area_mark(band.colour), band.label, ""});
  }
  for (const auto& level : chart.levels) {
    if (level.label.empty()) continue;
    entries.push_back({fmt::format(R"(<path d="M2 0H40" stroke="{}" stroke-width="3" )"
                                   R"(stroke-dasharray="9 7"/>)"
                                   "\n",
                                   faint_ink),
                       level.label, ""});
  }
  return entries;
}

std::string levels_of(const Chart& chart, const Scale& x, const Scale& y) {
  std::string data;
  for (const Level& level : chart.levels) {
    data += fmt::format("M{} {}H{}", px(x.from), px(y(level.y)), px(x.to));
  }
  if (data.empty()) return {};
  return fmt::format(R"(<path d="{}" stroke="{}" stroke-width="2.5" stroke-dasharray="9 7"/>)"
                     "\n",
                     data, faint_ink);
}

std::size_t widest(const std::vector<Tick>& some) {
  std::size_t letters = 1;
  for (const Tick& tick : some) letters = std::max(letters, width(tick.label));
  return letters;
}

Axes axes_of(const Chart& chart, double top) {
  const Range ys = y_range(chart);
  const auto y_ticks = ticks(ys, chart.y.scaling, 6.0);
  const double left = border + letter_width * tick_size * static_cast<double>(widest(y_ticks)) + 16;
  const Scale x{x_range(chart), chart.x.scaling, left, canvas - border - 12.0};
  const Scale y{ys, chart.y.scaling, top + chart.height, top};
  // Fewer ticks if their labels are long.
  const auto letters = static_cast<double>(widest(ticks(x.range, chart.x.scaling, 8.0)));
  const double needed = letter_width * tick_size * letters + 24.0;
  const double count = std::clamp((x.to - x.from) / needed, 2.0, 10.0);
  return {x, y, ticks(x.range, chart.x.scaling, count), y_ticks};
}

}  // namespace

Drawing draw(const Chart& chart) {
  double top = border;
  std::string words = title_at(chart.title, top);
  const Legend key = legend(entries_of(chart), top);
  top = key.bottom + (key.svg.empty() ? 0.0 : 4.0);
  words += svg::words(border, top + text_size, tick_size, fmt::format(R"(fill="{}")", faint_ink),
                      svg::escaped(chart.y.label));
  top += text_size + 18.0;

  const Axes axes = chart.is_map ? map_axes(view_of(chart), top) : axes_of(chart, top);
  const auto& [x, y, x_ticks, y_ticks] = axes;
  std::string inside = levels_of(chart, x, y);
  for (const Band& band : chart.bands) inside += draw_band(band, x, y);
  if (!chart.bars.empty()) inside += draw_bars(chart.bars, x, y);
  for (const Ellipse& ellipse : chart.ellipses) inside += draw_ellipse(ellipse, axes);
  for (const PlotSeries& series : chart.series)
    inside += chart.is_map ? draw_on_map(series, axes) : draw_series(series, x, y);
  if (chart.is_map) inside += draw_ends(chart.series, axes);

  Drawing drawing;
  drawing.name = chart.title.empty() ? chart.y.label + " over " + chart.x.label : chart.title;
  drawing.svg = words + key.svg + grid(x_ticks, y_ticks, x, y) + framed(x, y, inside) +
                svg::words(0.5 * (x.from + x.to), y.from + 2.0 * tick_size + 22.0, tick_size,
                           fmt::format(R"(text-anchor="middle" fill="{}")", faint_ink),
                           svg::escaped(chart.x.label));
  drawing.height = y.from + 2.0 * tick_size + 22.0 + border;
  return drawing;
}

}  // namespace odomd::tools::chart
