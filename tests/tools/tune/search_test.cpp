#include "tools/tune/search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace odomd::tools::search_test {
namespace {

/// A bowl with its bottom at (0.62, 0.31), long and askew.
double bowl(const Point& p) {
  const double x = p[0] - 0.62;
  const double y = p[1] - 0.31;
  return 1.0 + x * x + 4.0 * y * y + x * y;
}

Costs costs_of(double (*cost)(const Point&)) {
  return [cost](std::span<const Point> points) {
    std::vector<double> costs;
    for (const Point& point : points) costs.push_back(cost(point));
    return costs;
  };
}

TEST(CompassSearch, FindsTheBottomOfABowl) {
  const Found found = compass_search(costs_of(bowl), {0.1, 0.9}, {.last_step = 1e-3});
  EXPECT_NEAR(found.point[0], 0.62, 2e-3);
  EXPECT_NEAR(found.point[1], 0.31, 2e-3);
  EXPECT_DOUBLE_EQ(found.cost, bowl(found.point));
}

TEST(CompassSearch, StaysInTheCubeAndEndsAtItsFace) {
  const auto slope = [](const Point& p) { return p[0] - p[1]; };
  const Found found = compass_search(costs_of(slope), {0.5, 0.5}, {});
  EXPECT_EQ(found.point, (Point{0.0, 1.0}));
}

TEST(CompassSearch, GoesAroundWhatIsImpossible) {
  const auto walled = [](const Point& p) {
    return p[0] > 0.7 ? std::numeric_limits<double>::infinity() : 1.0 - p[0];
  };
  const Found found = compass_search(costs_of(walled), {0.2}, {.last_step = 0.01});
  EXPECT_GT(found.point[0], 0.68);
  EXPECT_LE(found.point[0], 0.7);
}

TEST(CompassSearch, KeepsToItsTrials) {
  std::size_t asked = 0;
  const Costs counted = [&](std::span<const Point> points) {
    asked += points.size();
    std::vector<double> costs;
    for (const Point& point : points) costs.push_back(bowl(point));
    return costs;
  };
  const Found found = compass_search(counted, {0.0, 0.0}, {.last_step = 1e-9, .trials = 30});
  EXPECT_LE(asked, 30U);
  EXPECT_EQ(found.trials, asked);
  EXPECT_TRUE(found.cut_short);
  EXPECT_FALSE(compass_search(counted, {0.0, 0.0}, {}).cut_short);
  EXPECT_LT(found.cost, bowl({0.0, 0.0}));
}

TEST(CompassSearch, AStartThatIsBestIsFound) {
  const Found found = compass_search(costs_of(bowl), {0.62, 0.31}, {});
  EXPECT_EQ(found.point, (Point{0.62, 0.31}));
}

}  // namespace
}  // namespace odomd::tools::search_test
