// Parts of charts: axes, thinned-out lines, escaped text.
#include <limits>

#include "tests/gtest.hpp"
#include "tools/chart/axis.hpp"
#include "tools/chart/chart.hpp"
#include "tools/chart/picture.hpp"

namespace odomd::tools::chart::chart_parts_test {
namespace {

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

TEST(Ticks, OfALogarithmicAxisAreDecadesOrFiner) {
  EXPECT_THAT(labels({5.0, 1000.0}, Scaling::logarithmic, 8),
              ElementsAre("5", "10", "20", "50", "100", "200", "500", "1000"));
  EXPECT_THAT(labels({0.01, 1000.0}, Scaling::logarithmic, 8),
              ElementsAre("0.01", "0.1", "1", "10", "100", "1000"));
  // With 50 as the only label, the height of 95 could not be read.
  EXPECT_THAT(labels({45.0, 98.0}, Scaling::logarithmic, 6), ElementsAre("60", "80"));
  EXPECT_THAT(labels({0.981, 1.0}, Scaling::logarithmic, 6),
              ElementsAre("0.985", "0.990", "0.995", "1.000"));
  EXPECT_THAT(labels({2.8, 3.5}, Scaling::logarithmic, 6), ElementsAre("2.8", "3.0", "3.2", "3.4"));
  EXPECT_LE(labels({1e-9, 1e9}, Scaling::logarithmic, 6).size(), 6U);
}

TEST(Scale, MapsLinearlyAndLogarithmically) {
  const Scale linear{{0.0, 10.0}, Scaling::linear, 100.0, 200.0};
  EXPECT_DOUBLE_EQ(linear(2.5), 125.0);
  const Scale down{{0.0, 10.0}, Scaling::linear, 200.0, 100.0};
  EXPECT_DOUBLE_EQ(down(2.5), 175.0);
  const Scale decades{{1.0, 100.0}, Scaling::logarithmic, 0.0, 2.0};
  EXPECT_NEAR(decades(10.0), 1.0, 1e-12);
}

TEST(Scale, LimitsFarValuesToWhatRenderersAccept) {
  const Scale linear{{0.0, 1.0}, Scaling::linear, 0.0, 1000.0};
  EXPECT_LT(linear(1e300), 1e6);
  EXPECT_GT(linear(-std::numeric_limits<double>::infinity()), -1e6);
  const Scale decades{{1.0, 100.0}, Scaling::logarithmic, 0.0, 1000.0};
  EXPECT_GT(decades(0.0), -1e6);
}

TEST(WithRoom, WidensARangeOfZeroWidth) {
  EXPECT_GT(with_room({3.0, 3.0}, Scaling::linear).width(), 0.5);
  EXPECT_GT(with_room({1e12, 1e12}, Scaling::linear).width(), 0.0);
  const Range decades = with_room({0.0, 0.0}, Scaling::logarithmic);
  EXPECT_GT(decades.low, 0.0);
  EXPECT_GT(decades.high, decades.low);
}

const Scale x{{0.0, 100.0}, Scaling::linear, 0.0, 1000.0};

std::vector<Point> wave(std::size_t count) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = 100.0 * static_cast<double>(i) / static_cast<double>(count - 1);
    points.push_back({at, std::sin(0.3 * at)});
  }
  return points;
}

TEST(Decimated, KeepsSpikesOfASingleSample) {
  std::vector<Point> points = wave(120'000);
  points[31'111].y = 17.0;
  points[31'113].y = -19.0;
  points[119'999].y = 5.0;
  const auto thin = decimated(points, x, 480);
  EXPECT_LE(thin.size(), 4U * 480U);
  const auto at = [&thin](double y) {
    return std::any_of(thin.begin(), thin.end(), [y](const Point& p) { return p.y == y; });
  };
  EXPECT_TRUE(at(17.0));
  EXPECT_TRUE(at(-19.0));
  EXPECT_TRUE(at(5.0));
}

TEST(Decimated, KeepsTheEndsAndTheOrder) {
  const std::vector<Point> points = wave(50'000);
  const auto thin = decimated(points, x, 100);
  EXPECT_EQ(thin.front().x, points.front().x);
  EXPECT_EQ(thin.back().x, points.back().x);
  for (std::size_t i = 1; i < thin.size(); ++i) EXPECT_GT(thin[i].x, thin[i - 1].x);
}

TEST(Decimated, KeepsAShortCurveExceptForPointsFarOutside) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto heights = [](const std::vector<Point>& points) {
    std::vector<double> all;
    for (const Point& point : decimated(points, x, 480)) all.push_back(point.y);
    return all;
  };
  std::vector<double> all;
  for (const Point& point : wave(50)) all.push_back(point.y);
  EXPECT_EQ(heights(wave(50)), all);
  // Successive gaps become one gap; on either side the nearest point outside the axis is kept.
  EXPECT_THAT(heights({{0, 1}, {1, nan}, {2, nan}, {3, 2}, {4, 3}}),
              ElementsAre(1.0, ::testing::IsNan(), 2.0, 3.0));
  EXPECT_THAT(heights({{-9, 1}, {-5, 2}, {50, 3}, {110, 4}, {120, 5}}), ElementsAre(2.0, 3.0, 4.0));
}

TEST(Decimated, KeepsTheGapsOfABand) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<BandPoint> band{
      {0.0, -1.0, 1.0}, {1.0, nan, nan}, {2.0, nan, nan}, {8.0, -1.0, 1.0}};
  const auto kept = decimated(band, Scale{{0.0, 10.0}, Scaling::linear, 0.0, 100.0}, 2);
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_TRUE(std::isnan(kept[1].low));
}

TEST(Decimated, KeepsTheFullWidthOfABand) {
  std::vector<BandPoint> band;
  for (int i = 0; i <= 10'000; ++i) band.push_back({0.01 * i, -1.0, 1.0});
  band[777] = {7.77, -8.0, 2.0};
  band[778] = {7.78, -1.0, 9.0};
  const auto thin = decimated(band, x, 100);
  EXPECT_LE(thin.size(), 100U);
  double low = 0.0, high = 0.0;
  for (const auto& p : thin) {
    low = std::min(low, p.low);
    high = std::max(high, p.high);
  }
  EXPECT_EQ(low, -8.0);
  EXPECT_EQ(high, 9.0);
}

TEST(Thinned, KeepsOutliersAndTheDensity) {
  // All within ±1, except one in a hundred at ±3.
  std::vector<Point> points;
  for (std::size_t i = 0; i < 100'000; ++i) {
    const double at = 100.0 * static_cast<double>(i) / 99'999.0;
    const double usual = std::sin(static_cast<double>(i * i % 6283) * 1e-3);
    points.push_back({at, i % 100 == 50 ? (i % 200 == 50 ? 3.0 : -3.0) : usual});
  }
  const auto thin = thinned(points, x, 100, 12);
  EXPECT_LE(thin.size(), 100U * 12U);
  const auto outer = std::ranges::count_if(thin, [](const Point& p) { return std::abs(p.y) > 2; });
  EXPECT_GE(outer, 2 * 100);                                       // no outlier is lost,
  EXPECT_LT(outer, static_cast<std::ptrdiff_t>(thin.size()) / 3);  // and most points are inside
  for (std::size_t i = 1; i < thin.size(); ++i) EXPECT_GT(thin[i].x, thin[i - 1].x);
}

TEST(Thinned, KeepsAllOfAFewDots) {
  const std::vector<Point> points = wave(400);
  EXPECT_EQ(thinned(points, x, 160, 12).size(), points.size());
}

TEST(Escaped, EscapesMarkupAndReplacesInvalidUtf8) {
  EXPECT_EQ(svg::escaped("a<b>&\"c\" ψ±3√S 🚗"), "a&lt;b&gt;&amp;&quot;c&quot; ψ±3√S 🚗");
  EXPECT_EQ(svg::escaped("two\nlines\x01"), "two\nlines ");
  EXPECT_EQ(svg::escaped("lap\xff.csv"), "lap\uFFFD.csv");
  EXPECT_EQ(svg::escaped("caf\xe9"), "caf\uFFFD");                // Latin-1
  EXPECT_EQ(svg::escaped("\xc0\xaf"), "\uFFFD\uFFFD");            // overlong encoding
  EXPECT_EQ(svg::escaped("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");  // a surrogate
  EXPECT_EQ(svg::escaped("\xf4\x90\x80\x80").size(), 4 * 3U);     // beyond U+10FFFF
  EXPECT_EQ(svg::escaped("cut \xe2\x82"), "cut \uFFFD");
}

}  // namespace
}  // namespace odomd::tools::chart::chart_parts_test
