// The view, the axes and the elements of a map, for draw(const Chart&).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/chart/chart.hpp"

namespace odomd::tools::chart {

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
