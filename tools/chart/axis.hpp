// Axes with round ticks, and legends.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace odomd::tools::chart {

enum class Scaling : std::uint8_t { linear, logarithmic };

struct Range {
  double low = 0.0;
  double high = 1.0;

  [[nodiscard]] double width() const { return high - low; }
  [[nodiscard]] bool holds(double value) const { return value >= low && value <= high; }
  [[nodiscard]] Range grown(double by) const { return {low - by, high + by}; }
  void take(double value) { *this = {std::min(low, value), std::max(high, value)}; }
};

/// An axis between two positions in the picture (user units; the low end is at `from`).
struct Scale {
  Range range;
  Scaling scaling = Scaling::linear;
  double from = 0.0;
  double to = 1.0;

  /// Values far outside, or without a logarithm, are placed at most 50 axis lengths outside.
  [[nodiscard]] double operator()(double value) const;
};

struct Tick {
  double value = 0.0;
  std::string label;  ///< with a true minus
};

/// Round numbers within the range, about `count` of them; on a logarithmic axis 1, 2 and 5 times
/// the powers of ten, or fewer.
[[nodiscard]] std::vector<Tick> ticks(const Range& range, Scaling scaling, double count);

/// 1, 2 or 5 times a power of ten, for about `count` steps over `length`.
[[nodiscard]] double round_step(double length, double count);

/// The range with some margin; a range of zero width is widened.
[[nodiscard]] Range with_room(Range range, Scaling scaling);

/// The number of decimals for steps of this size.
[[nodiscard]] int decimals_for(double step);

/// A number with a true minus (U+2212).
[[nodiscard]] std::string number(double value, int decimals);

/// The grid, and the numbers along both axes.
[[nodiscard]] std::string grid(const std::vector<Tick>& x_ticks, const std::vector<Tick>& y_ticks,
                               const Scale& x, const Scale& y);

/// The content of the plot, cut at its frame.
[[nodiscard]] std::string framed(const Scale& x, const Scale& y, const std::string& content);

/// The title, if there is one; moves `top` below it.
[[nodiscard]] std::string title_at(const std::string& title, double& top);

struct LegendEntry {
  std::string mark;   ///< SVG, drawn left of the words, from (0, 0) to the right
  std::string label;  ///< plain text
  std::string note;   ///< after the label, lighter
};

// Legend marks for a line, a dot and an area.
[[nodiscard]] std::string line_mark(const std::string& colour, double stroke);
[[nodiscard]] std::string dot_mark(const std::string& colour);
[[nodiscard]] std::string area_mark(const std::string& colour);

struct Legend {
  std::string svg;
  double bottom = 0.0;  ///< `top` if there is no entry
};

/// Rows of entries from the left, within the width of the canvas.
[[nodiscard]] Legend legend(const std::vector<LegendEntry>& entries, double top);

}  // namespace odomd::tools::chart
