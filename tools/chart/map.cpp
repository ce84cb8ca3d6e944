#include "tools/chart/map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>

#include <fmt/format.h>

#include "tools/chart/axis.hpp"
#include "tools/chart/picture.hpp"
#include "tools/chart/svg_elements.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools::chart {
namespace {

using svg::px;

// Overlapping laps need finer lines to stay distinguishable.
double fineness(std::span<const Point> points, double scale) {
  constexpr double many_laps = 9000.0;  // user units
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    length += scale * std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
  }
  return length > many_laps ? 0.6 : 1.0;
}

// A polyline without the points that do not differ visibly from a straight line (Reumann and Witkam
// 1974: those in a narrow strip along the direction in which a segment begins).
std::string path_data(std::span<const Point> points, const Layout& layout) {
  constexpr double finest = 1.0;  // user units: shortest segment, and width of the strip
  const Scale x = layout.x();
  const Scale y = layout.y();
  std::string data;
  const auto go_to = [&data](const Point& p) {
    data += fmt::format("{}{} {}", data.empty() ? 'M' : 'L', px(p.x), px(p.y));
  };
  Point from;    // the last point kept
  Point before;  // the newest point in the strip
  Point along;   // the strip's direction; (0, 0): none yet
  for (const Point& point : points) {
    const Point p{x(point.x), y(point.y)};
    const Point way{p.x - from.x, p.y - from.y};
    if (data.empty()) {
      go_to(p);
      from = p;
    } else if (along.x == 0.0 && along.y == 0.0) {
      const double length = std::hypot(way.x, way.y);
      if (length < finest) continue;
      along = {way.x / length, way.y / length};
    } else {
      const double sideways = std::abs(along.x * way.y - along.y * way.x);
      const double ahead =
          along.x * (p.x - before.x) + along.y * (p.y - before.y);  // turning back ends a segment
      if (sideways > 0.5 * finest || ahead < -0.5 * finest) {
        go_to(before);
        from = before;
        along = {};
      }
    }
    before = p;
  }
  go_to(before);
  return data;
}

std::string grid(const Layout& layout) {
  const Box& view = layout.view;
  // The same step for both axes gives squares.
  const double step = round_step(std::max(view.wide(), view.high()), 8.0);
  const auto in_metres = [step](const Range& range) {
    auto some = ticks(range, Scaling::linear, range.width() / step * (1.0 + 1e-9));
    if (!some.empty()) some.back().label += " m";
    return some;
  };
  const Scale x = layout.x(), y = layout.y();
  return chart::grid(in_metres(x.range), in_metres(y.range), x, y);
}

std::string ellipse(const Ellipse& region, const Layout& layout, const std::string& colour) {
  // Axes of the covariance: λ = (a + c)/2 ± √(((a − c)/2)² + b²), turned by ½ atan2(2b, a − c).
  const auto [a, b, c] = region.covariance;
  const double mean = 0.5 * (a + c);
  const double difference = std::hypot(0.5 * (a - c), b);
  const double major = 3.0 * std::sqrt(std::max(0.0, mean + difference)) * layout.scale;
  const double minor = 3.0 * std::sqrt(std::max(0.0, mean - difference)) * layout.scale;
  constexpr double largest = 0.4 * canvas;  // beyond, it would fill the picture
  if (!(major > 1.0) || major > largest) return {};
  const double turn = -0.5 * std::atan2(2.0 * b, a - c) * 180.0 / std::numbers::pi;
  return fmt::format(
      R"svg(<ellipse rx="{}" ry="{}" transform="translate({} {}) rotate({})" fill="{}" )svg"
      R"svg(fill-opacity="0.10" stroke="{}" stroke-width="2" stroke-dasharray="7 6"/>
)svg",
      px(major), px(minor), px(layout.x()(region.centre.x)), px(layout.y()(region.centre.y)),
      px(turn), colour, colour);
}

std::string dots(std::span<const Point> points, const Layout& layout) {
  // Thinned out, so that they remain separate dots and do not hide what lies below.
  constexpr double least_apart = 11.0;
  std::string out;
  Point before{-canvas, -canvas};
  for (const auto& p : points) {
    const Point at{layout.x()(p.x), layout.y()(p.y)};
    const bool crowded = std::hypot(at.x - before.x, at.y - before.y) < least_apart;
    if (!layout.view.holds(p) || crowded) continue;
    out += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"3.6\"/>\n", px(at.x), px(at.y));
    before = at;
  }
  return fmt::format("<g fill=\"{}\" fill-opacity=\"0.8\">\n{}</g>\n", dot_colour, out);
}

bool leaves(const Trace& trace, const Box& view) {
  return !std::all_of(trace.points.begin(), trace.points.end(),
                      [&view](const auto& p) { return view.holds(p); });
}

std::string colour_of(const Map& map, std::size_t estimate) {
  const std::string& own = map.estimates[estimate].colour;
  return own.empty() ? chart::colour_of(estimate) : own;
}

std::vector<LegendEntry> legend_entries(const Map& map, const Box& view) {
  std::vector<LegendEntry> entries;
  if (!map.reference.points.empty()) {
    entries.push_back({line_mark(reference_colour, 9.0), map.reference.label, map.reference.note});
  }
  for (std::size_t i = 0; i < map.estimates.size(); ++i) {
    const auto& trace = map.estimates[i];
    entries.push_back({line_mark(colour_of(map, i), 5.0), trace.label,
                       trace.note + (leaves(trace, view) ? " · leaves the picture" : "")});
  }
  if (!map.dots.empty()) {
    entries.push_back({dot_mark(dot_colour), map.dots_label, ""});
  }
  return entries;
}

// Lines first, then all marks over them: ends filled, the start hollow.
std::string traces(const Map& map, const Layout& layout) {
  const double fine = fineness(main_points(map), layout.scale);
  const auto mark = [&layout](const Point& at, double radius, const std::string& fill,
                              const std::string& stroke, double stroke_width) {
    return svg::disc(layout.x()(at.x), layout.y()(at.y), radius, fill, stroke, stroke_width);
  };
  std::string lines;
  std::string marks;
  if (!map.reference.points.empty()) {
    lines += svg::line(path_data(map.reference.points, layout), reference_colour, 9.0 * fine);
    marks += mark(map.reference.points.back(), 13.0, faint_ink, "#FFFFFF", 3.0);
  }
  if (!map.dots.empty()) lines += dots(map.dots, layout);
  for (std::size_t i = 0; i < map.estimates.size(); ++i) {
    const auto& trace = map.estimates[i];
    if (trace.points.empty()) continue;
    if (trace.end_ellipse) lines += ellipse(*trace.end_ellipse, layout, colour_of(map, i));
    lines += svg::line(path_data(trace.points, layout), colour_of(map, i), 3.5 * fine);
    marks += mark(trace.points.back(), 9.0, colour_of(map, i), "#FFFFFF", 2.5);
  }
  marks += mark(main_points(map).front(), 12.0, "#FFFFFF", ink, 4.0);
  return lines + marks;
}

}  // namespace

std::span<const Point> main_points(const Map& map) {
  if (!map.reference.points.empty()) return map.reference.points;
  return map.estimates.at(0).points;
}

Box view_of(const Map& map) {
  constexpr double smallest = 0.2;  // m
  constexpr double farthest = 1e9;  // m
  constexpr double margin = 0.06;   // of the size
  const auto points = main_points(map);
  Box view{points[0].x, points[0].x, points[0].y, points[0].y};
  for (const auto& p : points) view.take(p);
  if (!Box{-farthest, farthest, -farthest, farthest}.holds({view.left, view.bottom}) ||
      !Box{-farthest, farthest, -farthest, farthest}.holds({view.right, view.top})) {
    throw std::invalid_argument("a trajectory beyond a million kilometres cannot be drawn");
  }
  const double size = std::max({view.wide(), view.high(), smallest});
  const Box reach = view.grown(0.5 * size);
  for (const auto& trace : map.estimates) {
    for (const auto& p : trace.points) {
      view.take(
          {std::clamp(p.x, reach.left, reach.right), std::clamp(p.y, reach.bottom, reach.top)});
    }
  }
  return view.grown(margin * size);
}

Layout layout_of(const Box& view, double top) {
  constexpr double tallest = 1.3 * canvas;  // a tall track may be a third higher than wide
  constexpr double flattest = 0.3;          // least height / width of the plot
  // Room for the labels of the y axis, their unit, and a sign.
  const double step = round_step(std::max(view.wide(), view.high()), 8.0);
  const auto letters = [step](double value) {
    return width(number(value, decimals_for(step))) + 2;
  };
  const auto longest = static_cast<double>(std::max(letters(view.bottom), letters(view.top)));
  Layout layout;
  layout.view = view;
  layout.left = border + std::max(60.0, letter_width * tick_size * longest);
  layout.right = canvas - border - 12.0;
  layout.top = top;
  const double width = layout.right - layout.left;
  layout.scale = std::min(width / view.wide(), tallest / view.high());

  const double more_wide = width / layout.scale - view.wide();
  layout.view.left -= 0.5 * more_wide;
  layout.view.right += 0.5 * more_wide;
  const double more_high = std::max(0.0, flattest * width / layout.scale - view.high());
  layout.view.bottom -= 0.5 * more_high;
  layout.view.top += 0.5 * more_high;
  layout.bottom = top + layout.view.high() * layout.scale;
  return layout;
}

Drawing draw(const Map& map) {
  constexpr double label_below = tick_size + 20.0;  // room for the labels of the x axis
  const Box view = view_of(map);
  double top = border;
  const std::string title = title_at(map.title, top);
  const Legend words = legend(legend_entries(map, view), top);
  const Layout layout = layout_of(view, words.bottom + 16.0);
  Drawing drawing;
  drawing.name = map.title.empty() ? "trajectories" : map.title;
  drawing.svg =
      title + words.svg + grid(layout) + framed(layout.x(), layout.y(), traces(map, layout));
  drawing.height = layout.bottom + label_below + 0.5 * border;
  return drawing;
}

}  // namespace odomd::tools::chart
