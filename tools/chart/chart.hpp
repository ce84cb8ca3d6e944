// A chart: curves, bands and bars over an axis, or a map of trajectories.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/chart/axis.hpp"
#include "tools/chart/decimate.hpp"
#include "tools/chart/picture.hpp"

namespace odomd::tools::chart {

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

}  // namespace odomd::tools::chart
