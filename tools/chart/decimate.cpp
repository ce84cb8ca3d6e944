#include "tools/chart/decimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace odomd::tools::chart {
namespace {

// −1 before the range, `columns` behind it.
long column_of(double x, const Scale& scale, std::size_t columns) {
  const double share = (scale(x) - scale.from) / (scale.to - scale.from);
  if (share < 0.0) return -1;
  if (share > 1.0) return static_cast<long>(columns);
  return std::min(static_cast<long>(share * static_cast<double>(columns)),
                  static_cast<long>(columns) - 1);
}

bool is_gap(const Point& p) {
  return !std::isfinite(p.x) || !std::isfinite(p.y);
}

bool is_gap(const BandPoint& p) {
  return !std::isfinite(p.low) || !std::isfinite(p.high);
}

// The points of these indices, once each, in their order.
void take(std::span<const Point> points, std::span<std::ptrdiff_t> indices,
          std::vector<Point>& kept) {
  std::ranges::sort(indices);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (i > 0 && indices[i] == indices[i - 1]) continue;
    kept.push_back(points[static_cast<std::size_t>(indices[i])]);
  }
}

// What stays of points that share a column.
void keep(std::span<const Point> points, std::vector<Point>& kept) {
  if (points.empty()) return;
  const auto lower = [](const Point& a, const Point& b) { return a.y < b.y; };
  const auto [low, high] = std::minmax_element(points.begin(), points.end(), lower);
  std::array<std::ptrdiff_t, 4> indices{0, low - points.begin(), high - points.begin(),
                                        std::ssize(points) - 1};
  take(points, indices, kept);
}

void keep_some(std::span<const Point> points, std::size_t each, std::vector<Point>& kept) {
  if (points.size() <= each) {
    kept.insert(kept.end(), points.begin(), points.end());
    return;
  }
  const auto lower = [](const Point& a, const Point& b) { return a.y < b.y; };
  const auto [low, high] = std::minmax_element(points.begin(), points.end(), lower);
  std::vector<std::ptrdiff_t> indices{low - points.begin(), high - points.begin()};
  for (std::size_t i = 0; i + 2 < each; ++i)
    indices.push_back(static_cast<std::ptrdiff_t>(i * points.size() / (each - 2)));
  take(points, indices, kept);
}

// Hands the points of each column to `keep_those`.
template <typename Keep>
std::vector<Point> by_columns(std::span<const Point> points, const Scale& x, std::size_t columns,
                              const Keep& keep_those) {
  std::vector<Point> kept;
  const auto last_column = static_cast<long>(columns);
  std::size_t i = 0;
  while (i < points.size()) {
    if (is_gap(points[i])) {
      if (!kept.empty() && !is_gap(kept.back())) kept.push_back(points[i]);
      ++i;
      continue;
    }
    const long column = column_of(points[i].x, x, columns);
    std::size_t end = i + 1;
    while (end < points.size() && !is_gap(points[end]) &&
           column_of(points[end].x, x, columns) == column) {
      ++end;
    }
    if (column < 0) {
      kept.push_back(points[end - 1]);
    } else if (column == last_column) {
      kept.push_back(points[i]);
    } else {
      keep_those(points.subspan(i, end - i), kept);
    }
    i = end;
  }
  return kept;
}

}  // namespace

std::vector<Point> decimated(std::span<const Point> points, const Scale& x, std::size_t columns) {
  return by_columns(points, x, columns, keep);
}

std::vector<Point> thinned(std::span<const Point> points, const Scale& x, std::size_t columns,
                           std::size_t each) {
  return by_columns(points, x, columns,
                    [each](std::span<const Point> some, std::vector<Point>& kept) {
                      keep_some(some, each, kept);
                    });
}

std::vector<BandPoint> decimated(std::span<const BandPoint> points, const Scale& x,
                                 std::size_t columns) {
  std::vector<BandPoint> kept;
  long before = -2;
  for (const BandPoint& p : points) {
    if (is_gap(p)) {
      if (!kept.empty() && !is_gap(kept.back())) kept.push_back(p);
      before = -2;
      continue;
    }
    const long column = column_of(p.x, x, columns);
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
