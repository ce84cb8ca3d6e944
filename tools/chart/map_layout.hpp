// The region and the scale of a map: metres on one side, user units of the SVG on the other.
#pragma once

#include <algorithm>
#include <span>

#include "tools/chart/axis.hpp"
#include "tools/chart/map.hpp"

namespace odomd::tools::chart {

/// A region in metres, y upwards.
struct Box {
  double left = 0.0;
  double right = 0.0;
  double bottom = 0.0;
  double top = 0.0;

  void take(const Point& p) {
    left = std::min(left, p.x);
    right = std::max(right, p.x);
    bottom = std::min(bottom, p.y);
    top = std::max(top, p.y);
  }
  [[nodiscard]] double wide() const { return right - left; }
  [[nodiscard]] double high() const { return top - bottom; }
  [[nodiscard]] bool holds(const Point& p) const {
    return p.x >= left && p.x <= right && p.y >= bottom && p.y <= top;
  }
  [[nodiscard]] Box grown(double by) const {
    return {left - by, right + by, bottom - by, top + by};
  }
};

/// The plot: equal axes.
struct Layout {
  Box view;                                                 ///< what is shown [m]
  double scale = 1.0;                                       ///< user units per metre
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;  ///< the frame, user units, y downwards

  [[nodiscard]] Scale x() const { return {{view.left, view.right}, Scaling::linear, left, right}; }
  [[nodiscard]] Scale y() const { return {{view.bottom, view.top}, Scaling::linear, bottom, top}; }
};

/// The main trajectory: the reference, else the first estimate.
[[nodiscard]] std::span<const Point> main_points(const Map& map);

/// The region to show: the main trajectory with a margin, and the others as far as they stay within
/// half its size of it. Throws std::invalid_argument beyond a million kilometres.
[[nodiscard]] Box view_of(const Map& map);

/// Fits a view into the width of the canvas, below `top`.
[[nodiscard]] Layout layout_of(const Box& view, double top);

}  // namespace odomd::tools::chart
