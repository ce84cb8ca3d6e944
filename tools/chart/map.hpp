// A map: trajectories with the same scale for both axes, and its layout.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/chart/axis.hpp"
#include "tools/chart/decimate.hpp"
#include "tools/chart/picture.hpp"

namespace odomd::tools::chart {

/// The ellipse of three standard deviations of a 2-D normal distribution.
struct Ellipse {
  Point centre;
  std::array<double, 3> covariance{};  ///< xx, xy, yy [m²]
};

struct Trace {
  std::string label;  ///< in the legend
  std::string note;   ///< after the label, lighter: "1.23 cm/m"
  std::vector<Point> points;
  std::optional<Ellipse> end_ellipse = {};  ///< 3σ at the end
  std::string colour = {};                  ///< empty: colour_of(index); the reference has its own
};

struct Map {
  std::string title;  ///< may be empty
  Trace reference;
  std::vector<Trace> estimates;
  std::vector<Point> dots;  ///< camera poses
  std::string dots_label;
};

/// The view covers the reference and the parts of the estimates near it. An estimate that runs away
/// is cut at the border, with a note in the legend. Needs at least one point in the reference or an
/// estimate.
[[nodiscard]] Drawing draw(const Map& map);

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

/// Position of the plot, and its scale, which is the same for both axes.
struct Layout {
  Box view;                                                 ///< what is shown [m]
  double scale = 1.0;                                       ///< user units per metre
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;  ///< the frame, user units, y downwards

  [[nodiscard]] Scale x() const { return {{view.left, view.right}, Scaling::linear, left, right}; }
  [[nodiscard]] Scale y() const { return {{view.bottom, view.top}, Scaling::linear, bottom, top}; }
};

/// The main trajectory: the reference, or the first estimate if there is none.
[[nodiscard]] std::span<const Point> main_points(const Map& map);

/// The region to show: the main trajectory with a margin, and the parts of the others within half
/// its size around it. Throws std::invalid_argument beyond a million kilometres.
[[nodiscard]] Box view_of(const Map& map);

/// Fits a view into the width of the canvas, below `top`.
[[nodiscard]] Layout layout_of(const Box& view, double top);

}  // namespace odomd::tools::chart
