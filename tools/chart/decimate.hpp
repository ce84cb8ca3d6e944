// Lines with as many points as a picture can show.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tools/chart/axis.hpp"

namespace odomd::tools::chart {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

/// A strip around a curve: low and high at x.
struct BandPoint {
  double x = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// The range of x is cut into columns; of each column's points the first, the lowest, the highest
/// and the last stay, in their order. x must not decrease. Points that are not finite are gaps; of
/// successive ones one stays. Points outside the range are removed except those next to it.
[[nodiscard]] std::vector<Point> decimated(std::span<const Point> points, const Scale& x,
                                           std::size_t columns);

/// Likewise for a band: each column's lowest low and highest high, and gaps.
[[nodiscard]] std::vector<BandPoint> decimated(std::span<const BandPoint> points, const Scale& x,
                                               std::size_t columns);

/// Likewise for dots. Each column keeps at most `each` (three or more): its lowest, its highest and
/// some others, so that the density remains visible.
[[nodiscard]] std::vector<Point> thinned(std::span<const Point> points, const Scale& x,
                                         std::size_t columns, std::size_t each);

}  // namespace odomd::tools::chart
