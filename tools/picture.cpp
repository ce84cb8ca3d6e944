#include "tools/picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "tools/picture_layout.hpp"
#include "tools/svg.hpp"
#include "tools/text.hpp"

namespace odomd::tools {
namespace {

using svg::px;

constexpr double title_height = 64.0;
constexpr double legend_row = 48.0;
constexpr double text_size = 30.0;  // legible at the width of a phone
constexpr double tick_size = 26.0;

// Okabe and Ito's colours: told apart by colour-blind eyes and in grey print.
constexpr std::array<const char*, 6> colours{"#0072B2", "#D55E00", "#009E73",
                                             "#CC79A7", "#56B4E9", "#8A6D00"};
constexpr const char* reference_colour = "#A9AFB7";
constexpr const char* dot_colour = "#E8A100";
constexpr const char* ink = "#1F2933";
constexpr const char* faint_ink = "#6B7280";

std::string colour_of(std::size_t estimate) {
  return colours[estimate % colours.size()];
}

// Many laps over each other need finer lines to be told apart.
double fineness(std::span<const PicturePoint> points, double scale) {
  constexpr double many_laps = 9000.0;  // user units
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    length += scale * std::hypot(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
  }
  return length > many_laps ? 0.6 : 1.0;
}

// A polyline without the points that nobody could tell apart.
std::string path_data(std::span<const PicturePoint> points, const Layout& layout) {
  constexpr double finest = 0.7;    // user units
  constexpr double farthest = 1e5;  // runaways stay numbers that any renderer takes
  std::string data;
  double last_x = 0.0;
  double last_y = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = std::clamp(layout.x(points[i].x), -farthest, farthest);
    const double y = std::clamp(layout.y(points[i].y), -farthest, farthest);
    const bool told_apart = std::hypot(x - last_x, y - last_y) >= finest;
    if (i != 0 && !told_apart && i + 1 != points.size()) continue;
    data += fmt::format("{}{} {}", i == 0 ? 'M' : 'L', px(x), px(y));
    last_x = x;
    last_y = y;
  }
  return data;
}

// A tick label: a true minus, and the unit on the last one.
std::string label_of(double value, int decimals, bool last) {
  std::string text = fixed(value, decimals);
  if (text.starts_with('-')) text.replace(0, 1, "\u2212");
  return text + (last ? " m" : "");
}

std::string grid(const Layout& layout) {
  const Box& view = layout.view;
  const double step = round_step(std::max(view.wide(), view.high()), 8.0);
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  std::string lines;
  std::string labels;
  const auto each = [step](double from, double to, const auto& draw_one) {
    const auto first = static_cast<long>(std::ceil(from / step));
    const auto last = static_cast<long>(std::floor(to / step));
    for (long i = first; i <= last; ++i) draw_one(static_cast<double>(i) * step, i == last);
  };
  each(view.left, view.right, [&](double value, bool last) {
    const double x = layout.x(value);
    lines += fmt::format("M{} {}V{}", px(x), px(layout.top), px(layout.bottom));
    labels += svg::words(x, layout.bottom + 36.0, tick_size, R"(text-anchor="middle")",
                         label_of(value, decimals, last));
  });
  each(view.bottom, view.top, [&](double value, bool last) {
    const double y = layout.y(value);
    lines += fmt::format("M{} {}H{}", px(layout.left), px(y), px(layout.right));
    labels += svg::words(layout.left - 12.0, y + 9.0, tick_size, R"(text-anchor="end")",
                         label_of(value, decimals, last));
  });
  return svg::line(lines, "#E6E9ED", 1.5) +
         fmt::format("<g fill=\"{}\">\n{}</g>\n", faint_ink, labels);
}

std::string ellipse(const PictureEllipse& region, const Layout& layout, const std::string& colour) {
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
      px(major), px(minor), px(layout.x(region.centre.x)), px(layout.y(region.centre.y)), px(turn),
      colour, colour);
}

std::string dots(std::span<const PicturePoint> points, const Layout& layout) {
  // Thinned out, so that they stay dots and what lies below stays visible.
  constexpr double least_apart = 11.0;
  std::string out;
  PicturePoint before{-canvas, -canvas};
  for (const auto& p : points) {
    const PicturePoint at{layout.x(p.x), layout.y(p.y)};
    const bool crowded = std::hypot(at.x - before.x, at.y - before.y) < least_apart;
    if (!layout.view.holds(p) || crowded) continue;
    out += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"3.6\"/>\n", px(at.x), px(at.y));
    before = at;
  }
  return fmt::format("<g fill=\"{}\" fill-opacity=\"0.8\">\n{}</g>\n", dot_colour, out);
}

bool leaves(const PictureTrace& trace, const Box& view) {
  return !std::all_of(trace.points.begin(), trace.points.end(),
                      [&view](const auto& p) { return view.holds(p); });
}

struct LegendEntry {
  std::string mark;  // drawn left of the words, around the origin
  std::string label;
  std::string note;
};

std::vector<LegendEntry> legend_entries(const Picture& picture, const Box& view) {
  const auto swatch = [](const std::string& colour, double stroke) {
    return svg::line("M3 0H47", colour, stroke);
  };
  std::vector<LegendEntry> entries;
  if (!picture.reference.points.empty()) {
    entries.push_back(
        {swatch(reference_colour, 9.0), picture.reference.label, picture.reference.note});
  }
  for (std::size_t i = 0; i < picture.estimates.size(); ++i) {
    const auto& trace = picture.estimates[i];
    entries.push_back({swatch(colour_of(i), 5.0), trace.label,
                       trace.note + (leaves(trace, view) ? " · leaves the picture" : "")});
  }
  if (!picture.dots.empty()) {
    entries.push_back({svg::disc(38.0, 0.0, 7.0, dot_colour, "none", 0.0), picture.dots_label, ""});
  }
  return entries;
}

struct Legend {
  std::string svg;
  double bottom = 0.0;
};

// Rows of entries from the left.
Legend legend(const std::vector<LegendEntry>& entries, double top) {
  constexpr double mark_width = 62.0;
  constexpr double gap = 44.0;
  constexpr double letter = 0.56 * text_size;  // mean width; generous, fonts differ
  Legend result;
  double x = border;
  double y = top + 0.5 * legend_row;
  for (const auto& entry : entries) {
    const std::size_t letters =
        width(entry.label) + (entry.note.empty() ? 0 : width(entry.note) + 1);
    const double needed = mark_width + letter * static_cast<double>(letters);
    if (x > border && x + needed > canvas - border) {
      x = border;
      y += legend_row;
    }
    std::string content = svg::escaped(entry.label);
    if (!entry.note.empty()) {
      content += fmt::format(R"(<tspan fill="{}" dx="12">{}</tspan>)", faint_ink,
                             svg::escaped(entry.note));
    }
    result.svg += fmt::format(
        "<g transform=\"translate({} {})\">\n{}{}</g>\n", px(x), px(y), entry.mark,
        svg::words(mark_width, 10.0, text_size, fmt::format(R"(fill="{}")", ink), content));
    x += needed + gap;
  }
  result.bottom = y + 0.5 * legend_row;
  return result;
}

// Lines first, the marks of all over them: ends filled, the start hollow.
std::string traces(const Picture& picture, const Layout& layout) {
  const double fine = fineness(main_points(picture), layout.scale);
  const auto mark = [&layout](const PicturePoint& at, double radius, const std::string& fill,
                              const std::string& stroke, double stroke_width) {
    return svg::disc(layout.x(at.x), layout.y(at.y), radius, fill, stroke, stroke_width);
  };
  std::string lines;
  std::string marks;
  if (!picture.reference.points.empty()) {
    lines += svg::line(path_data(picture.reference.points, layout), reference_colour, 9.0 * fine);
    marks += mark(picture.reference.points.back(), 13.0, faint_ink, "#FFFFFF", 3.0);
  }
  if (!picture.dots.empty()) lines += dots(picture.dots, layout);
  for (std::size_t i = 0; i < picture.estimates.size(); ++i) {
    const auto& trace = picture.estimates[i];
    if (trace.points.empty()) continue;
    if (trace.end_ellipse) lines += ellipse(*trace.end_ellipse, layout, colour_of(i));
    lines += svg::line(path_data(trace.points, layout), colour_of(i), 3.5 * fine);
    marks += mark(trace.points.back(), 9.0, colour_of(i), "#FFFFFF", 2.5);
  }
  marks += mark(main_points(picture).front(), 12.0, "#FFFFFF", ink, 4.0);
  return lines + marks;
}

}  // namespace

std::string draw(const Picture& picture) {
  constexpr double label_below = 52.0;  // room for the labels of the x axis
  const Box view = view_of(picture);
  const double legend_top = 0.5 * border + (picture.title.empty() ? 0.0 : title_height);
  const Legend words = legend(legend_entries(picture, view), legend_top);
  const Layout layout = layout_of(view, words.bottom + 18.0);
  const double height = layout.bottom + label_below + 0.4 * border;

  std::string title;
  if (!picture.title.empty()) {
    title = svg::words(border, 0.5 * border + 44.0, 38.0,
                       fmt::format(R"(font-weight="bold" fill="{}")", ink),
                       svg::escaped(picture.title));
  }
  const std::string frame =
      fmt::format(R"(x="{}" y="{}" width="{}" height="{}")", px(layout.left), px(layout.top),
                  px(layout.right - layout.left), px(layout.bottom - layout.top));
  return fmt::format(
      R"svg(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0} {1}" width="{0}" height="{1}" )svg"
      R"svg(font-family="'DejaVu Sans', Verdana, Arial, sans-serif">
<rect width="100%" height="100%" fill="#FFFFFF"/>
{2}{3}{4}<clipPath id="plot"><rect {5}/></clipPath>
<g clip-path="url(#plot)">
{6}</g>
<rect {5} fill="none" stroke="#CBD2D9" stroke-width="2"/>
</svg>
)svg",
      px(canvas), px(height), title, words.svg, grid(layout), frame, traces(picture, layout));
}

}  // namespace odomd::tools
