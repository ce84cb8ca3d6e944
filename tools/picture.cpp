#include "tools/picture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "tools/text.hpp"

namespace odomd::tools {
namespace {

// Measures in user units; the picture is as wide as `canvas`, whatever it is shown at.
constexpr double canvas = 1200.0;
constexpr double border = 36.0;
constexpr double label_left = 76.0;   // room for the labels of the y axis
constexpr double label_below = 52.0;  // and of the x axis
constexpr double title_height = 64.0;
constexpr double legend_row = 48.0;
constexpr double text_size = 30.0;
constexpr double tick_size = 26.0;

// Okabe and Ito's colours: told apart by colour-blind eyes and in grey print.
constexpr std::array<const char*, 6> colours{"#0072B2", "#D55E00", "#009E73",
                                             "#CC79A7", "#56B4E9", "#8A6D00"};
constexpr const char* reference_colour = "#A9AFB7";
constexpr const char* dot_colour = "#E8A100";

struct Box {
  double left = 0.0, right = 0.0, bottom = 0.0, top = 0.0;

  void take(const PicturePoint& p) {
    left = std::min(left, p.x);
    right = std::max(right, p.x);
    bottom = std::min(bottom, p.y);
    top = std::max(top, p.y);
  }
  [[nodiscard]] double wide() const { return right - left; }
  [[nodiscard]] double high() const { return top - bottom; }
  [[nodiscard]] bool holds(const PicturePoint& p) const {
    return p.x >= left && p.x <= right && p.y >= bottom && p.y <= top;
  }
  [[nodiscard]] Box grown(double by) const {
    return {left - by, right + by, bottom - by, top + by};
  }
};

Box box_of(std::span<const PicturePoint> points) {
  Box box{points[0].x, points[0].x, points[0].y, points[0].y};
  for (const auto& p : points) box.take(p);
  return box;
}

// What is shown, in metres: the reference with room around it, and estimates as far as they stay
// within half its size of it.
Box view_of(const Picture& picture) {
  constexpr double smallest = 0.2;  // m
  const auto& anchor =
      picture.reference.points.empty() ? picture.estimates.at(0).points : picture.reference.points;
  Box view = box_of(anchor);
  const double size = std::max({view.wide(), view.high(), smallest});
  const Box farthest = view.grown(0.5 * size);
  for (const auto& trace : picture.estimates) {
    for (const auto& p : trace.points) {
      view.take({std::clamp(p.x, farthest.left, farthest.right),
                 std::clamp(p.y, farthest.bottom, farthest.top)});
    }
  }
  return view.grown(0.06 * size);
}

// 1, 2 or 5 times a power of ten, for about `count` lines over `length`.
double round_step(double length, double count) {
  const double raw = length / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10.0 * power;
}

std::string px(double value) {
  return fixed(value, 1);
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c >= '\0' && c < ' ') {
      out += ' ';
    } else {
      out += c;
    }
  }
  return out;
}

// Metres to user units: equal axes, y upwards.
struct Map {
  Box view;
  double scale = 1.0;  // user units per metre
  double left = 0.0, top = 0.0;

  [[nodiscard]] double x(double metres) const { return left + (metres - view.left) * scale; }
  [[nodiscard]] double y(double metres) const { return top + (view.top - metres) * scale; }
};

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
std::string path_data(std::span<const PicturePoint> points, const Map& map) {
  constexpr double finest = 0.7;    // user units
  constexpr double farthest = 1e5;  // runaways stay numbers that any renderer takes
  std::string data;
  double last_x = 0.0;
  double last_y = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = std::clamp(map.x(points[i].x), -farthest, farthest);
    const double y = std::clamp(map.y(points[i].y), -farthest, farthest);
    const bool told_apart = std::hypot(x - last_x, y - last_y) >= finest;
    if (i != 0 && !told_apart && i + 1 != points.size()) continue;
    data += (i == 0 ? "M" : "L") + px(x) + " " + px(y);
    last_x = x;
    last_y = y;
  }
  return data;
}

std::string line(const std::string& data, const std::string& colour, double stroke) {
  return "<path d=\"" + data + "\" fill=\"none\" stroke=\"" + colour + "\" stroke-width=\"" +
         px(stroke) + "\" stroke-linejoin=\"round\" stroke-linecap=\"round\"/>\n";
}

std::string disc(double x, double y, double radius, const std::string& fill,
                 const std::string& stroke, double stroke_width) {
  return "<circle cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"" + px(radius) + "\" fill=\"" +
         fill + "\" stroke=\"" + stroke + "\" stroke-width=\"" + px(stroke_width) + "\"/>\n";
}

std::string words(double x, double y, double size, const std::string& attributes,
                  const std::string& content) {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" font-size=\"" + px(size) + "\" " +
         attributes + ">" + content + "</text>\n";
}

// A tick label: a true minus, and the unit on the last one.
std::string label_of(double value, int decimals, bool last) {
  std::string text = fixed(value, decimals);
  if (text.starts_with('-')) text.replace(0, 1, "\u2212");
  return text + (last ? " m" : "");
}

std::string grid(const Map& map, double right, double bottom) {
  const Box& view = map.view;
  const double step = round_step(std::max(view.wide(), view.high()), 8.0);
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  std::string out;
  std::string labels;
  const auto lines = [&](double from, double to, const auto& draw_one) {
    const auto first = static_cast<long>(std::ceil(from / step));
    const auto last = static_cast<long>(std::floor(to / step));
    for (long i = first; i <= last; ++i) {
      draw_one(static_cast<double>(i) * step, i == last);
    }
  };
  lines(view.left, view.right, [&](double value, bool last) {
    const std::string x = px(map.x(value));
    out += "<path d=\"M" + x + " " + px(map.top) + "V" + px(bottom) + "\"/>\n";
    labels += words(map.x(value), bottom + 36.0, tick_size, "text-anchor=\"middle\"",
                    label_of(value, decimals, last));
  });
  lines(view.bottom, view.top, [&](double value, bool last) {
    const std::string y = px(map.y(value));
    out += "<path d=\"M" + px(map.left) + " " + y + "H" + px(right) + "\"/>\n";
    labels += words(map.left - 12.0, map.y(value) + 9.0, tick_size, "text-anchor=\"end\"",
                    label_of(value, decimals, last));
  });
  return "<g stroke=\"#E6E9ED\" stroke-width=\"1.5\">\n" + out + "</g>\n<g fill=\"#6B7280\">\n" +
         labels + "</g>\n";
}

std::string ellipse(const PictureEllipse& region, const Map& map, const std::string& colour) {
  // Axes of the covariance: λ = (a + c)/2 ± √(((a − c)/2)² + b²), turned by ½ atan2(2b, a − c).
  const auto [a, b, c] = region.covariance;
  const double mean = 0.5 * (a + c);
  const double difference = std::hypot(0.5 * (a - c), b);
  const double major = 3.0 * std::sqrt(std::max(0.0, mean + difference)) * map.scale;
  const double minor = 3.0 * std::sqrt(std::max(0.0, mean - difference)) * map.scale;
  constexpr double largest = 0.4 * canvas;  // beyond, it would fill the picture
  if (!(major > 1.0) || major > largest) return {};
  const double turn = -0.5 * std::atan2(2.0 * b, a - c) * 180.0 / std::numbers::pi;
  return "<ellipse rx=\"" + px(major) + "\" ry=\"" + px(minor) + "\" transform=\"translate(" +
         px(map.x(region.centre.x)) + " " + px(map.y(region.centre.y)) + ") rotate(" + px(turn) +
         ")\" fill=\"" + colour + "\" fill-opacity=\"0.10\" stroke=\"" + colour +
         "\" stroke-width=\"2\" stroke-dasharray=\"7 6\"/>\n";
}

struct LegendEntry {
  std::string mark;  // drawn left of the words, around the origin
  std::string label;
  std::string note;
};

// Rows of entries from the left; returns the SVG and the rows it took.
std::string legend(const std::vector<LegendEntry>& entries, double top, int& rows) {
  constexpr double mark_width = 62.0;
  constexpr double gap = 44.0;
  constexpr double letter = 0.56 * text_size;  // mean width; generous, fonts differ
  std::string out;
  double x = border;
  rows = 1;
  for (const auto& entry : entries) {
    const double label_width = letter * static_cast<double>(width(entry.label));
    const double note_width =
        entry.note.empty() ? 0.0 : letter * static_cast<double>(width(entry.note) + 1);
    const double needed = mark_width + label_width + note_width;
    if (x > border && x + needed > canvas - border) {
      x = border;
      ++rows;
    }
    const double y = top + legend_row * (rows - 0.5);
    std::string content = escaped(entry.label);
    if (!entry.note.empty()) {
      content += "<tspan fill=\"#6B7280\" dx=\"12\">" + escaped(entry.note) + "</tspan>";
    }
    out += "<g transform=\"translate(" + px(x) + " " + px(y) + ")\">\n" + entry.mark +
           words(mark_width, 10.0, text_size, "fill=\"#1F2933\"", content) + "</g>\n";
    x += needed + gap;
  }
  return out;
}

std::string swatch(const std::string& colour, double stroke) {
  return line("M3 0H47", colour, stroke);
}

bool leaves(const PictureTrace& trace, const Box& view) {
  return !std::all_of(trace.points.begin(), trace.points.end(),
                      [&view](const auto& p) { return view.holds(p); });
}

}  // namespace

std::string draw(const Picture& picture) {
  Map map;
  map.view = view_of(picture);

  std::vector<LegendEntry> entries;
  if (!picture.reference.points.empty()) {
    entries.push_back(
        {swatch(reference_colour, 9.0), picture.reference.label, picture.reference.note});
  }
  for (std::size_t i = 0; i < picture.estimates.size(); ++i) {
    const auto& trace = picture.estimates[i];
    const std::string note = trace.note + (leaves(trace, map.view) ? " · leaves the picture" : "");
    entries.push_back({swatch(colours[i % colours.size()], 5.0), trace.label, note});
  }
  if (!picture.dots.empty()) {
    entries.push_back({disc(38.0, 0.0, 7.0, dot_colour, "none", 0.0), picture.dots_label, ""});
  }
  const double legend_top = picture.title.empty() ? 0.5 * border : 0.5 * border + title_height;
  int rows = 0;
  const std::string legend_svg = legend(entries, legend_top, rows);

  // The longer side fills the width; a tall track may be a third higher than wide.
  constexpr double tallest = 1.3 * canvas;
  map.left = border + label_left;
  map.top = legend_top + legend_row * rows + 18.0;
  const double plot_width = canvas - border - map.left;
  map.scale = std::min(plot_width / map.view.wide(), tallest / map.view.high());
  const double spare = plot_width / map.scale - map.view.wide();  // show more, keep equal axes
  map.view.left -= 0.5 * spare;
  map.view.right += 0.5 * spare;
  // A flat one is given some air.
  const double least_high = 0.3 * plot_width / map.scale;
  if (map.view.high() < least_high) {
    const double more = 0.5 * (least_high - map.view.high());
    map.view.bottom -= more;
    map.view.top += more;
  }
  const double right = canvas - border;
  const double bottom = map.top + map.view.high() * map.scale;
  const double height = bottom + label_below + 0.4 * border;

  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + px(canvas) + " " +
                    px(height) + "\" width=\"" + px(canvas) + "\" height=\"" + px(height) +
                    "\" font-family=\"'DejaVu Sans', Verdana, Arial, sans-serif\">\n"
                    "<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n";
  if (!picture.title.empty()) {
    svg += words(border, 0.5 * border + 44.0, 38.0, "font-weight=\"bold\" fill=\"#1F2933\"",
                 escaped(picture.title));
  }
  svg += legend_svg;

  const std::string frame = "x=\"" + px(map.left) + "\" y=\"" + px(map.top) + "\" width=\"" +
                            px(right - map.left) + "\" height=\"" + px(bottom - map.top) + "\"";
  svg += "<clipPath id=\"plot\"><rect " + frame + "/></clipPath>\n";
  svg += grid(map, right, bottom);
  svg += "<g clip-path=\"url(#plot)\">\n";
  const auto& main_points =
      picture.reference.points.empty() ? picture.estimates.at(0).points : picture.reference.points;
  const double fine = fineness(main_points, map.scale);
  if (!picture.reference.points.empty()) {
    svg += line(path_data(picture.reference.points, map), reference_colour, 9.0 * fine);
  }
  if (!picture.dots.empty()) {
    svg += "<g fill=\"" + std::string{dot_colour} + "\" fill-opacity=\"0.8\">\n";
    // Thinned out, so that they stay dots and what lies below stays visible.
    constexpr double least_apart = 11.0;
    PicturePoint before{-canvas, -canvas};
    for (const auto& p : picture.dots) {
      const PicturePoint at{map.x(p.x), map.y(p.y)};
      if (!map.view.holds(p) || std::hypot(at.x - before.x, at.y - before.y) < least_apart)
        continue;
      svg += "<circle cx=\"" + px(at.x) + "\" cy=\"" + px(at.y) + "\" r=\"3.6\"/>\n";
      before = at;
    }
    svg += "</g>\n";
  }
  for (std::size_t i = 0; i < picture.estimates.size(); ++i) {
    const auto& trace = picture.estimates[i];
    const std::string colour = colours[i % colours.size()];
    if (trace.end_ellipse) svg += ellipse(*trace.end_ellipse, map, colour);
    svg += line(path_data(trace.points, map), colour, 3.5 * fine);
  }
  // The marks of all, over all lines: ends filled, the start hollow.
  if (!picture.reference.points.empty()) {
    const auto& end = picture.reference.points.back();
    svg += disc(map.x(end.x), map.y(end.y), 13.0, "#6B7280", "#FFFFFF", 3.0);
  }
  for (std::size_t i = 0; i < picture.estimates.size(); ++i) {
    if (picture.estimates[i].points.empty()) continue;
    const auto& end = picture.estimates[i].points.back();
    svg += disc(map.x(end.x), map.y(end.y), 9.0, colours[i % colours.size()], "#FFFFFF", 2.5);
  }
  const auto& started =
      picture.reference.points.empty() ? picture.estimates.at(0).points : picture.reference.points;
  svg += disc(map.x(started.front().x), map.y(started.front().y), 12.0, "#FFFFFF", "#1F2933", 4.0);
  svg +=
      "</g>\n<rect " + frame + " fill=\"none\" stroke=\"#CBD2D9\" stroke-width=\"2\"/>\n</svg>\n";
  return svg;
}

}  // namespace odomd::tools
