// What a picture shows and at which scale: metres on one side, user units of the SVG on the other.
#pragma once

#include <algorithm>
#include <span>

#include "tools/picture.hpp"

namespace odomd::tools {

/// The picture is as wide as this, in user units, whatever it is shown at.
inline constexpr double canvas = 1200.0;
inline constexpr double border = 36.0;

/// A region in metres, y upwards.
struct Box {
  double left = 0.0;
  double right = 0.0;
  double bottom = 0.0;
  double top = 0.0;

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

/// The plot: equal axes.
struct Layout {
  Box view;                                                 ///< what is shown [m]
  double scale = 1.0;                                       ///< user units per metre
  double left = 0.0, right = 0.0, top = 0.0, bottom = 0.0;  ///< the frame, user units, y downwards

  [[nodiscard]] double x(double metres) const { return left + (metres - view.left) * scale; }
  [[nodiscard]] double y(double metres) const { return top + (view.top - metres) * scale; }
};

/// The trajectory that the picture is about: the reference, else the first estimate.
[[nodiscard]] std::span<const PicturePoint> main_points(const Picture& picture);

/// What is to be shown: the main trajectory with room around it, and the others as far as they stay
/// within half its size of it. Throws std::invalid_argument beyond a million kilometres.
[[nodiscard]] Box view_of(const Picture& picture);

/// Fits a view into the width of the canvas, below `top`.
[[nodiscard]] Layout layout_of(const Box& view, double top);

/// 1, 2 or 5 times a power of ten, for about `count` steps over `length`.
[[nodiscard]] double round_step(double length, double count);

}  // namespace odomd::tools
