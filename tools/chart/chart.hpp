// A chart: curves, bands and bars over an axis, or a map of trajectories.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/chart/axis.hpp"
#include "tools/chart/picture.hpp"

namespace odomd::tools::chart {

// Lines with as many points as a picture can show.

struct Point {
  double x = 0.0;
  double y = 0.0;
};

/// A strip around a curve: low and high at x.
struct BandPoint {
  double x = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// Divides the range of x into columns, and keeps the first, lowest, highest and last point of
/// each, in their order. x must not decrease. Points that are not finite are gaps; successive gaps
/// become one. Outside the range, only the points next to it are kept.
[[nodiscard]] std::vector<Point> decimated(std::span<const Point> points, const Scale& x,
                                           std::size_t columns);

/// Likewise for a band: keeps each column's lowest low and highest high, and gaps.
[[nodiscard]] std::vector<BandPoint> decimated(std::span<const BandPoint> points, const Scale& x,
                                               std::size_t columns);

/// Likewise for dots. Each column keeps at most `each` (three or more): its lowest, its highest and
/// some others, so that the density remains visible.
[[nodiscard]] std::vector<Point> thinned(std::span<const Point> points, const Scale& x,
                                         std::size_t columns, std::size_t each);

struct Axis {
  std::string label;  ///< with its unit: "time [s]"
  Scaling scaling = Scaling::linear;
  std::optional<Range> range;  ///< nothing: that of the data, for y with a margin
};

enum class Mark : std::uint8_t {
  line,
  dots,   ///< many, drawn small
  discs,  ///< few, drawn large
  line_and_dots
};

struct PlotSeries {
  std::string label;  ///< in the legend; empty: no entry
  std::string note;   ///< after the label, lighter
  std::string colour;
  std::vector<Point> points;  ///< x must not decrease; a value that is not finite is a gap
  Mark mark = Mark::line;
  double stroke = 3.0;
};

struct Band {
  std::string label;
  std::string colour;
  std::vector<BandPoint> points;  ///< x must not decrease; a value that is not finite is a gap
};

/// A bar of a histogram, from the axis up.
struct Bar {
  double low = 0.0;
  double high = 0.0;
  double height = 0.0;
};

/// The ellipse of three standard deviations of a 2-D normal distribution.
struct Ellipse {
  Point centre;
  std::array<double, 3> covariance{};  ///< xx, xy, yy
  std::string colour;
};

/// A dashed horizontal line.
struct Level {
  double y = 0.0;
  std::string label;  ///< in the legend; empty: no entry
};

struct Chart {
  std::string title;  ///< may be empty
  Axis x;
  Axis y;
  std::vector<Band> bands;
  std::vector<Bar> bars;
  std::vector<Level> levels;
  std::vector<PlotSeries> series;  ///< later ones are drawn over earlier ones
  std::vector<Ellipse> ellipses;
  double height = 440.0;  ///< of the plot, without its labels
  bool is_map = false;    ///< equal scales; x of a series may decrease; ranges and height follow
};

/// Draws as many points as are visible. Bands extend the range of y only near the curves. A map
/// shows the first line and what is near it: lines that leave the map are cut at its border, with a
/// note in the legend. Lines of a map end in a disc; the first begins with a ring.
[[nodiscard]] Drawing draw(const Chart& chart);

// The view, the axes and the elements of a map, for draw(const Chart&).

/// What a map shows.
struct View {
  Range x;
  Range y;

  [[nodiscard]] bool holds(const Point& p) const { return x.holds(p.x) && y.holds(p.y); }
};

/// Shows the first line, and other lines within half its size around it, with a margin.
[[nodiscard]] View view_of(const Chart& map);

/// A plot's axes.
struct Axes {
  Scale x;
  Scale y;
  std::vector<Tick> x_ticks;
  std::vector<Tick> y_ticks;
};

/// Fits a view into the width of the canvas, below `top`.
[[nodiscard]] Axes map_axes(const View& view, double top);

/// Keeps the points that are at least this far from the previous one (user units), and the last
/// point.
[[nodiscard]] std::vector<Point> spaced(std::span<const Point> points, const Axes& axes,
                                        double distance);

/// Empty if the ellipse is too small to see, or would fill the picture.
[[nodiscard]] std::string draw_ellipse(const Ellipse& ellipse, const Axes& axes);

/// The end of every line, and the start of the first.
[[nodiscard]] std::string draw_ends(const std::vector<PlotSeries>& lines, const Axes& axes);

}  // namespace odomd::tools::chart
