#include "tools/chart/axis.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace odomd::tools::chart::axis_test {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> labels(const Range& range, Scaling scaling, double count) {
  std::vector<std::string> all;
  for (const Tick& tick : ticks(range, scaling, count)) all.push_back(tick.label);
  return all;
}

TEST(Ticks, AreRoundNumbersWithinTheRange) {
  EXPECT_THAT(labels({-0.3, 1.02}, Scaling::linear, 5), ElementsAre("0.0", "0.5", "1.0"));
  EXPECT_THAT(labels({-2.0, 2.0}, Scaling::linear, 4), ElementsAre("−2", "−1", "0", "1", "2"));
  EXPECT_THAT(labels({0.0, 0.004}, Scaling::linear, 4),
              ElementsAre("0.000", "0.001", "0.002", "0.003", "0.004"));
}

TEST(Ticks, OfALogarithmicAxisAreDecadesAndFinerWhereThereIsRoom) {
  EXPECT_THAT(labels({5.0, 1000.0}, Scaling::logarithmic, 8),
              ElementsAre("5", "10", "20", "50", "100", "200", "500", "1000"));
  EXPECT_THAT(labels({0.01, 1000.0}, Scaling::logarithmic, 8),
              ElementsAre("0.01", "0.1", "1", "10", "100", "1000"));
  // 50 alone would not show how far up 95 is.
  EXPECT_THAT(labels({45.0, 98.0}, Scaling::logarithmic, 6), ElementsAre("60", "80"));
  EXPECT_THAT(labels({0.981, 1.0}, Scaling::logarithmic, 6),
              ElementsAre("0.985", "0.990", "0.995", "1.000"));
  EXPECT_THAT(labels({2.8, 3.5}, Scaling::logarithmic, 6), ElementsAre("2.8", "3.0", "3.2", "3.4"));
  EXPECT_LE(labels({1e-9, 1e9}, Scaling::logarithmic, 6).size(), 6U);
}

TEST(Scale, MapsBothWaysOfScaling) {
  const Scale linear{{0.0, 10.0}, Scaling::linear, 100.0, 200.0};
  EXPECT_DOUBLE_EQ(linear(2.5), 125.0);
  const Scale down{{0.0, 10.0}, Scaling::linear, 200.0, 100.0};
  EXPECT_DOUBLE_EQ(down(2.5), 175.0);
  const Scale decades{{1.0, 100.0}, Scaling::logarithmic, 0.0, 2.0};
  EXPECT_NEAR(decades(10.0), 1.0, 1e-12);
}

TEST(Scale, KeepsWhatRunsAwayANumberThatARendererTakes) {
  const Scale linear{{0.0, 1.0}, Scaling::linear, 0.0, 1000.0};
  EXPECT_LT(linear(1e300), 1e6);
  EXPECT_GT(linear(-std::numeric_limits<double>::infinity()), -1e6);
  const Scale decades{{1.0, 100.0}, Scaling::logarithmic, 0.0, 1000.0};
  EXPECT_GT(decades(0.0), -1e6);
}

TEST(WithRoom, GivesARangeOfNoWidthSome) {
  EXPECT_GT(with_room({3.0, 3.0}, Scaling::linear).width(), 0.5);
  EXPECT_GT(with_room({1e12, 1e12}, Scaling::linear).width(), 0.0);
  const Range decades = with_room({0.0, 0.0}, Scaling::logarithmic);
  EXPECT_GT(decades.low, 0.0);
  EXPECT_GT(decades.high, decades.low);
}

}  // namespace
}  // namespace odomd::tools::chart::axis_test
