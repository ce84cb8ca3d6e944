// A long curve made as fine as its picture: spikes survive, whatever the drive's length.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tools/chart/axis.hpp"
#include "tools/chart/point.hpp"

namespace odomd::tools::chart {

/// The range of x is cut into columns; of each column's points the first, the lowest, the highest
/// and the last stay, in their order. x must not decrease. Points that are not finite are gaps: of
/// one after the other one stays. Points outside the range go, but for those next to it.
[[nodiscard]] std::vector<Point> decimated(std::span<const Point> points, const Scale& x,
                                           std::size_t columns);

/// Likewise of a band: a column's lowest low and highest high, and gaps.
[[nodiscard]] std::vector<BandPoint> decimated(std::span<const BandPoint> points, const Scale& x,
                                               std::size_t columns);

/// Likewise of dots, of which each column keeps `each` at the most (three or more): its lowest, its
/// highest and others as they come, so that dense ones still show where most of them lie.
[[nodiscard]] std::vector<Point> thinned(std::span<const Point> points, const Scale& x,
                                         std::size_t columns, std::size_t each);

}  // namespace odomd::tools::chart
