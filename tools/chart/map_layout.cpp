#include "tools/chart/map_layout.hpp"

#include <cmath>
#include <stdexcept>

#include "tools/chart/axis.hpp"
#include "tools/chart/style.hpp"
#include "tools/cli/text.hpp"

namespace odomd::tools::chart {

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
  constexpr double flattest = 0.3;          // a flat one is given some air
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

}  // namespace odomd::tools::chart
