// A chart: curves, bands and bars over an axis.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/chart/axis.hpp"
#include "tools/chart/decimate.hpp"
#include "tools/chart/drawing.hpp"

namespace odomd::tools::chart {

struct Axis {
  std::string label;  ///< with its unit: "time [s]"
  Scaling scaling = Scaling::linear;
  std::optional<Range> range;  ///< else the range of the data, with a margin
};

enum class Mark : std::uint8_t {
  line,
  dots,   ///< many
  discs,  ///< few, each of which counts
  line_and_dots
};

struct Series {
  std::string label;  ///< in the legend; empty: not there
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

/// Of a histogram: from the axis up.
struct Bar {
  double low = 0.0;
  double high = 0.0;
  double height = 0.0;
};

/// A dashed line across.
struct Level {
  double y = 0.0;
  std::string label;  ///< in the legend; empty: not there
};

struct Chart {
  std::string title;  ///< may be empty
  Axis x;
  Axis y;
  std::vector<Band> bands;
  std::vector<Bar> bars;
  std::vector<Level> levels;
  std::vector<Series> series;  ///< the later ones over the earlier ones
  double height = 440.0;       ///< of the plot, without what is written around it
};

/// Thinned out to what can be seen. Bands count for the range of y only as far as they stay near
/// the curves.
[[nodiscard]] Drawing draw(const Chart& chart);

}  // namespace odomd::tools::chart
