#include "tools/chart/chart.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "tests/tools/markup.hpp"
#include "tools/chart/drawing.hpp"
#include "tools/chart/svg.hpp"

namespace odomd::tools::chart::chart_test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Colours, DistinguishADozenThings) {
  std::set<std::string> different;
  for (std::size_t i = 0; i < 12; ++i) different.insert(colour_of(i));
  EXPECT_EQ(different.size(), 12U);
}

Chart sine() {
  Chart chart;
  chart.title = "R&D <sine>";
  chart.x.label = "time [s]";
  chart.y.label = "value [m]";
  Series series{"model", "1.0 cm/m", "#0072B2", {}};
  Band band{"3σ", "#0072B2", {}};
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.01 * i;
    series.points.push_back({t, std::sin(t)});
    band.points.push_back({t, -2.0, 2.0});
  }
  chart.series = {series};
  chart.bands = {band};
  chart.levels = {{0.5, "limit"}};
  return chart;
}

std::string svg_of(const Chart& chart) {
  return as_svg(std::array{draw(chart)});
}

TEST(Chart, IsWellFormedWithItsWordsEscaped) {
  const std::string svg = svg_of(sine());
  EXPECT_EQ(markup_fault(svg), "");
  for (const char* words :
       {"R&amp;D &lt;sine", "time [s]", "value [m]", "model", "1.0 cm/m", "3σ", "limit"}) {
    EXPECT_THAT(svg, HasSubstr(words));
  }
}

TEST(Chart, BreaksABandWhereThereIsNone) {
  Chart chart = sine();
  chart.levels.clear();
  const auto pieces = [](const std::string& svg) {
    const auto end = svg.rfind("fill-opacity");
    const auto begin = svg.rfind("<path", end);
    const std::string data = svg.substr(begin, end - begin);
    return std::ranges::count(data, 'Z');
  };
  EXPECT_EQ(pieces(svg_of(chart)), 1);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 400; i < 600; ++i) chart.bands[0].points[i].low = nan;
  EXPECT_EQ(pieces(svg_of(chart)), 2);
}

TEST(Chart, OfUnusualDataIsStillAPicture) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double inf = std::numeric_limits<double>::infinity();
  Chart empty;
  Chart constant = sine();
  constant.series[0].points = {{1.0, 3.0}, {1.0, 3.0}};
  constant.bands.clear();
  Chart not_finite = sine();
  not_finite.series[0].points[7].y = nan;
  not_finite.series[0].points[8].y = inf;
  not_finite.bands[0].points[9].high = nan;
  Chart decades = sine();
  decades.x.scaling = decades.y.scaling = Scaling::logarithmic;
  Chart bars;
  bars.bars = {{1.0, 2.0, 5.0}, {2.0, 3.0, 0.0}};
  for (const Chart& chart : {empty, constant, not_finite, decades, bars}) {
    const std::string svg = svg_of(chart);
    EXPECT_EQ(markup_fault(svg), "");
    EXPECT_THAT(svg, Not(AnyOf(HasSubstr("nan"), HasSubstr("inf\""), HasSubstr("inf "))));
  }
}

TEST(Chart, OfALongDriveIsNoLargerThanItsPicture) {
  Chart chart;
  Series series{"long", "", "#0072B2", {}};
  for (int i = 0; i < 400'000; ++i) series.points.push_back({0.005 * i, std::sin(0.1 * i)});
  chart.series = {series};
  EXPECT_LT(svg_of(chart).size(), 60'000U);
}

TEST(Drawings, StandBelowEachOther) {
  const Drawing one = draw(sine());
  const std::string svg = as_svg(std::array{one, one});
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 1000.0 " + svg::px(2.0 * one.height) + "\""));
}

}  // namespace
}  // namespace odomd::tools::chart::chart_test
