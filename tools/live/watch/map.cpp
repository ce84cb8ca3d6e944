// A map in braille dots: the trail, the car and its uncertainty.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/text.hpp"
#include "tools/live/watch/page.hpp"

namespace odomd::tools::watch {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double min_extent = 1.0;  // m: a stationary car is not magnified beyond this

// A cell of the terminal is two dots wide and four dots high, and about half as wide as high, so
// dots are square.
constexpr std::size_t dots_across = 2;
constexpr std::size_t dots_down = 4;

// A grid of dots in cells of braille; a cell has the style of what was drawn in it last.
class Dots {
 public:
  Dots(std::size_t columns, std::size_t rows)
      : columns_(columns), rows_(rows), cells_(columns * rows) {}

  void set(double x, double y, Style style) {
    if (!holds(x, y)) return;
    const auto across = static_cast<std::size_t>(x);
    const auto down = static_cast<std::size_t>(y);
    // Braille numbers its dots column by column, the lowest row separately.
    constexpr std::array<std::array<unsigned, dots_across>, dots_down> bits{
        {{0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}}};
    Cell& cell = at(across / dots_across, down / dots_down);
    cell.dots |= bits[down % dots_down][across % dots_across];
    cell.style = style;
  }

  void line(double x0, double y0, double x1, double y1, Style style) {
    constexpr double most = 1000.0;  // more than any screen has
    const double length = std::max(std::abs(x1 - x0), std::abs(y1 - y0));
    const int steps = static_cast<int>(std::clamp(std::ceil(length), 1.0, most));
    for (int i = 0; i <= steps; ++i)
      set(x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps, style);
  }

  void mark(double x, double y, std::string_view character, Style style) {
    if (!holds(x, y)) return;
    at(static_cast<std::size_t>(x) / dots_across, static_cast<std::size_t>(y) / dots_down) = {
        0, style, character};
  }

  [[nodiscard]] Lines lines() const {
    Lines all;
    for (std::size_t row = 0; row < rows_; ++row) {
      Line line;
      for (std::size_t column = 0; column < columns_; ++column) {
        const Cell& cell = cells_[row * columns_ + column];
        if (line.empty() || line.back().style != cell.style) line.push_back({"", cell.style});
        line.back().text += character(cell);
      }
      all.push_back(std::move(line));
    }
    return all;
  }

 private:
  struct Cell {
    unsigned dots = 0;
    Style style = Style::plain;
    std::string_view character;  // shown instead of dots
  };

  [[nodiscard]] bool holds(double x, double y) const {
    return x >= 0.0 && y >= 0.0 && x < static_cast<double>(columns_ * dots_across) &&
           y < static_cast<double>(rows_ * dots_down);
  }

  Cell& at(std::size_t column, std::size_t row) { return cells_[row * columns_ + column]; }

  static std::string character(const Cell& cell) {
    if (!cell.character.empty()) return std::string{cell.character};
    if (cell.dots == 0) return " ";
    // U+2800 plus the dots, in UTF-8.
    return {static_cast<char>(0xE2), static_cast<char>(0xA0U | cell.dots >> 6U),
            static_cast<char>(0x80U | (cell.dots & 0x3FU))};
  }

  std::size_t columns_;
  std::size_t rows_;
  std::vector<Cell> cells_;
};

struct Box {
  double x0, x1, y0, y1;  // m
  void include(double x, double y) {
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
};

// The part of the map that the dots show.
struct Section {
  double metres_a_dot = 1.0;
  double left = 0.0;  // m
  double top = 0.0;   // m
  [[nodiscard]] double across(double x) const { return (x - left) / metres_a_dot; }
  [[nodiscard]] double down(double y) const { return (top - y) / metres_a_dot; }
};

double snapped(double value, double step) {
  return std::round(value / step) * step;
}

// The finest of the steps at which the box fits.
Section section_for(const Box& box, double dots_wide, double dots_high) {
  constexpr std::array steps{1.0, 1.5, 2.0, 3.0, 5.0, 7.0};
  constexpr double snap_dots = 8.0;
  for (int power = -4;; ++power) {
    for (const double step : steps) {
      const double scale = step * std::pow(10.0, power);
      const double snap = snap_dots * scale;
      const Section section{scale, snapped((box.x0 + box.x1) / 2.0, snap) - dots_wide / 2.0 * scale,
                            snapped((box.y0 + box.y1) / 2.0, snap) + dots_high / 2.0 * scale};
      const bool fits = section.across(box.x0) >= 1.0 && section.down(box.y1) >= 1.0 &&
                        section.across(box.x1) < dots_wide - 1.0 &&
                        section.down(box.y0) < dots_high - 1.0;
      // Coordinates beyond any planet are too coarse to fit at any step.
      if (fits || power > 9) return section;
    }
  }
}

std::string_view arrow(double yaw) {
  constexpr std::array<std::string_view, 8> arrows{"→", "↗", "↑", "↖", "←", "↙", "↓", "↘"};
  const auto eighth = static_cast<long>(std::lround(std::remainder(yaw, 2.0 * pi) / (pi / 4.0)));
  return arrows[static_cast<std::size_t>((eighth + 8) % 8)];
}

// "├──────┤ 2 m": a length of 1, 2 or 5 times a power of ten, at most a quarter of the map's width.
Line scale_bar(double metres_a_column, std::size_t columns) {
  const double wanted = metres_a_column * static_cast<double>(columns) / 4.0;
  const double power = std::pow(10.0, std::floor(std::log10(wanted)));
  const double first = wanted / power;
  const double metres = power * (first >= 5.0 ? 5.0 : first >= 2.0 ? 2.0 : 1.0);
  const auto cells = static_cast<std::size_t>(std::max(2L, std::lround(metres / metres_a_column)));
  std::string bar = "├";
  for (std::size_t i = 2; i < cells; ++i) bar += "─";
  const std::string length =
      metres >= 1.0 ? fixed(metres, 0) + " m" : fixed(100.0 * metres, 0) + " cm";
  return {{bar + "┤ " + length, Style::dim}};
}

}  // namespace

Ellipse ellipse_of(const std::array<double, 3>& covariance, double sigmas) {
  const auto [xx, xy, yy] = covariance;
  const double mean = (xx + yy) / 2.0;
  const double radius = std::hypot((xx - yy) / 2.0, xy);
  return {sigmas * std::sqrt(std::max(mean + radius, 0.0)),
          sigmas * std::sqrt(std::max(mean - radius, 0.0)),
          radius > 0.0 ? std::atan2(2.0 * xy, xx - yy) / 2.0 : 0.0};
}

Lines draw_map(const Trail& trail, const odom_pose& pose, std::size_t columns, std::size_t rows) {
  if (!std::isfinite(pose.x) || !std::isfinite(pose.y)) return Lines(rows);
  --rows;  // the last one has the scale
  Box box{pose.x - min_extent / 2.0, pose.x + min_extent / 2.0, pose.y - min_extent / 2.0,
          pose.y + min_extent / 2.0};
  for (const TrailPoint& point : trail.points()) box.include(point.x, point.y);
  const Section section = section_for(box, static_cast<double>(columns * dots_across),
                                      static_cast<double>(rows * dots_down));

  Dots dots{columns, rows};
  const Ellipse ellipse =
      ellipse_of({pose.covariance[0], pose.covariance[1], pose.covariance[3]}, 3.0);
  constexpr int pieces = 180;
  for (int i = 0; i < pieces; ++i) {
    const double angle = 2.0 * pi * i / pieces;
    const double along = ellipse.long_half_axis * std::cos(angle);
    const double across = ellipse.short_half_axis * std::sin(angle);
    const double c = std::cos(ellipse.direction);
    const double s = std::sin(ellipse.direction);
    dots.set(section.across(pose.x + c * along - s * across),
             section.down(pose.y + s * along + c * across), Style::warning);
  }
  const TrailPoint* before = nullptr;
  for (const TrailPoint& point : trail.points()) {
    const TrailPoint& from = before != nullptr && point.joined ? *before : point;
    dots.line(section.across(from.x), section.down(from.y), section.across(point.x),
              section.down(point.y), Style::accent);
    before = &point;
  }
  dots.mark(section.across(pose.x), section.down(pose.y), arrow(pose.yaw), Style::strong);

  Lines lines = dots.lines();
  lines.push_back(scale_bar(section.metres_a_dot * dots_across, columns));
  return lines;
}

}  // namespace odomd::tools::watch
