// A map of trajectories, in metres on equal axes.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "tools/chart/drawing.hpp"
#include "tools/chart/point.hpp"

namespace odomd::tools::chart {

/// The region of a 2-D normal distribution within three standard deviations along each axis of it.
struct Ellipse {
  Point centre;
  std::array<double, 3> covariance{};  ///< xx, xy, yy [m²]
};

struct Trace {
  std::string label;  ///< in the legend
  std::string note;   ///< after the label, lighter: "1.23 cm/m"
  std::vector<Point> points;
  std::optional<Ellipse> end_ellipse = {};  ///< 3σ at the end
  std::string colour = {};                  ///< empty: by its place; the reference has its own
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

}  // namespace odomd::tools::chart
