#include "tools/chart/chart.hpp"

#include <algorithm>
#include <cmath>

namespace odomd::tools::chart {
namespace {

// The column of x; −1 before the range, `count` after it.
long column_of(double x, const Scale& scale, std::size_t count) {
  const double share = (scale(x) - scale.from) / (scale.to - scale.from);
  if (share < 0.0) return -1;
  if (share > 1.0) return static_cast<long>(count);
  return std::min(static_cast<long>(share * static_cast<double>(count)),
                  static_cast<long>(count) - 1);
}

bool is_gap(const Point& p) {
  return !std::isfinite(p.x) || !std::isfinite(p.y);
}

bool is_gap(const BandPoint& p) {
  return !std::isfinite(p.low) || !std::isfinite(p.high);
}

// Keeps a column's lowest and highest point, and `each` − 2 others, spread evenly. If `each` is 0,
// the first and the last point replace the others.
void keep(std::span<const Point> points, std::size_t each, std::vector<Point>& kept) {
  const auto lower = [](const Point& a, const Point& b) { return a.y < b.y; };
  const auto [low, high] = std::minmax_element(points.begin(), points.end(), lower);
  std::vector<std::ptrdiff_t> indices{low - points.begin(), high - points.begin()};
  if (each == 0) indices.insert(indices.end(), {0, std::ssize(points) - 1});
  for (std::size_t i = 0; i + 2 < each; ++i)
    indices.push_back(static_cast<std::ptrdiff_t>(i * points.size() / (each - 2)));
  std::ranges::sort(indices);
  indices.erase(std::unique(indices.begin(), indices.end()), indices.end());
  for (const std::ptrdiff_t index : indices)
    kept.push_back(points[static_cast<std::size_t>(index)]);
}

}  // namespace

std::vector<Point> thinned(std::span<const Point> points, const Scale& x, std::size_t count,
                           std::size_t each) {
  std::vector<Point> kept;
  const auto last_column = static_cast<long>(count);
  std::size_t i = 0;
  while (i < points.size()) {
    if (is_gap(points[i])) {
      if (!kept.empty() && !is_gap(kept.back())) kept.push_back(points[i]);
      ++i;
      continue;
    }
    const long column = column_of(points[i].x, x, count);
    std::size_t end = i + 1;
    while (end < points.size() && !is_gap(points[end]) &&
           column_of(points[end].x, x, count) == column) {
      ++end;
    }
    if (column < 0) {
      kept.push_back(points[end - 1]);
    } else if (column == last_column) {
      kept.push_back(points[i]);
    } else {
      const auto some = points.subspan(i, end - i);
      if (some.size() <= each)
        kept.insert(kept.end(), some.begin(), some.end());
      else
        keep(some, each, kept);
    }
    i = end;
  }
  return kept;
}

std::vector<Point> decimated(std::span<const Point> points, const Scale& x, std::size_t count) {
  return thinned(points, x, count, 0);
}

std::vector<BandPoint> decimated(std::span<const BandPoint> points, const Scale& x,
                                 std::size_t count) {
  std::vector<BandPoint> kept;
  long before = -2;
  for (const BandPoint& p : points) {
    if (is_gap(p)) {
      if (!kept.empty() && !is_gap(kept.back())) kept.push_back(p);
      before = -2;
      continue;
    }
    const long column = column_of(p.x, x, count);
    if (column != before) {
      kept.push_back(p);
      before = column;
      continue;
    }
    kept.back().low = std::min(kept.back().low, p.low);
    kept.back().high = std::max(kept.back().high, p.high);
  }
  return kept;
}

}  // namespace odomd::tools::chart
