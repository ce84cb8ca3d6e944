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

/// Divides the range of x into columns, and keeps the first, lowest, highest and last point of
/// each, in their order. x must not decrease. Points that are not finite are gaps; successive gaps
/// become one. Outside the range, only the points next to it are kept.
[[nodiscard]] std::vector<Point> decimated(std::span<const Point> points, const Scale& x,
                                           std::size_t columns);

/// Likewise for a band: keeps each column's lowest low and highest high, and gaps.
[[nodiscard]] std::vector<BandPoint> decimated(std::span<const BandPoint> points, const Scale& x,
                                               std::size_t columns);

/// Likewise for dots. Each column keeps at most `each` (three or more): its lowest, its highest and
/// some others, so that the density remains visible.
[[nodiscard]] std::vector<Point> thinned(std::span<const Point> points, const Scale& x,
                                         std::size_t columns, std::size_t each);

}  // namespace odomd::tools::chart
