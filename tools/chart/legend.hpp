// The legend: rows above the picture.
#pragma once

#include <string>
#include <vector>

namespace odomd::tools::chart {

struct LegendEntry {
  std::string mark;   ///< SVG, drawn left of the words, from (0, 0) to the right
  std::string label;  ///< plain text
  std::string note;   ///< after the label, lighter
};

// Marks of a line, a dot, and an area.
[[nodiscard]] std::string line_mark(const std::string& colour, double stroke);
[[nodiscard]] std::string dot_mark(const std::string& colour);
[[nodiscard]] std::string area_mark(const std::string& colour);

struct Legend {
  std::string svg;
  double bottom = 0.0;  ///< `top` if there is no entry
};

/// Rows of entries from the left, as wide as the canvas.
[[nodiscard]] Legend legend(const std::vector<LegendEntry>& entries, double top);

}  // namespace odomd::tools::chart
