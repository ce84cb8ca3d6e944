// Charts and maps, as SVG.
#include <limits>
#include <set>

#include "tests/tools/scratch.hpp"
#include "tools/chart/chart.hpp"
#include "tools/chart/picture.hpp"

namespace odomd::tools::chart::charts_test {
namespace {

using ::testing::AnyOf;

TEST(Colours, AreDistinctForTwelveItems) {
  std::set<std::string> different;
  for (std::size_t i = 0; i < 12; ++i) different.insert(colour_of(i));
  EXPECT_EQ(different.size(), 12U);
}

Chart sine() {
  Chart chart;
  chart.title = "R&D <sine>";
  chart.x.label = "time [s]";
  chart.y.label = "value [m]";
  PlotSeries series{"model", "1.0 cm/m", "#0072B2", {}};
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

TEST(Chart, IsWellFormedAndEscapesItsWords) {
  const std::string svg = svg_of(sine());
  EXPECT_EQ(markup_fault(svg), "");
  for (const char* words :
       {"R&amp;D &lt;sine", "time [s]", "value [m]", "model", "1.0 cm/m", "3σ", "limit"}) {
    EXPECT_THAT(svg, HasSubstr(words));
  }
}

TEST(Chart, BreaksABandAtAGap) {
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

TEST(Chart, DrawsUnusualData) {
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
  Chart standing;
  standing.is_map = true;
  standing.series = {{"reference", "", reference_colour, {{2.0, 3.0}, {2.0, 3.0}}}};
  for (const Chart& chart : {empty, constant, not_finite, decades, bars, standing}) {
    const std::string svg = svg_of(chart);
    EXPECT_EQ(markup_fault(svg), "");
    EXPECT_THAT(svg, Not(AnyOf(HasSubstr("nan"), HasSubstr("inf\""), HasSubstr("inf "))));
  }
}

TEST(Chart, LimitsTheSizeOfALongDrive) {
  Chart chart;
  PlotSeries series{"long", "", "#0072B2", {}};
  for (int i = 0; i < 400'000; ++i) series.points.push_back({0.005 * i, std::sin(0.1 * i)});
  chart.series = {series};
  EXPECT_LT(svg_of(chart).size(), 60'000U);
}

TEST(Drawings, AreStackedVertically) {
  const Drawing one = draw(sine());
  const std::string svg = as_svg(std::array{one, one});
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 1000.0 " + svg::px(2.0 * one.height) + "\""));
}

Chart circle_map() {
  Chart map;
  map.title = "R&D <lap>";
  map.is_map = true;
  map.series = {{"reference", "6.3 m", reference_colour, {}, Mark::line, 9.0},
                {"camera", "", dot_colour, {}, Mark::dots},
                {"paper", "1.25 cm/m", colour_of(0), {}}};
  for (int i = 0; i <= 100; ++i) {
    const double a = 0.0628 * i;
    map.series[0].points.push_back({std::cos(a), std::sin(a)});
    map.series[1].points.push_back({1.02 * std::cos(a), 1.02 * std::sin(a)});
    map.series[2].points.push_back({1.05 * std::cos(a), 1.05 * std::sin(a)});
  }
  map.ellipses = {{map.series[2].points.back(), {0.01, 0.0, 0.0025}, colour_of(0)}};
  return map;
}

TEST(Map, IsAnSvgWithALegendAndEscapesItsWords) {
  const std::string svg = svg_of(circle_map());
  EXPECT_THAT(svg, StartsWith("<svg xmlns="));
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_THAT(svg,
              AllOf(HasSubstr("R&amp;D &lt;lap&gt;"), HasSubstr("1.25 cm/m"), HasSubstr("<ellipse"),
                    Not(HasSubstr("leaves the picture")), Not(HasSubstr("nan"))));
}

TEST(Map, HasEqualAxes) {
  // A unit circle is drawn as wide as high, according to the extremes of its path data.
  const std::string svg = svg_of(circle_map());
  const auto start = svg.find("<path d=\"M", svg.find("<svg x=")) + 10;
  std::istringstream data{svg.substr(start, svg.find('"', start) - start)};
  Range across{1e9, -1e9}, down{1e9, -1e9};
  double x = 0.0, y = 0.0;
  for (char separator = 0; data >> x >> y; data >> separator) {
    across.take(x);
    down.take(y);
  }
  EXPECT_GT(across.width(), 500.0);
  EXPECT_NEAR(across.width(), down.width(), 2.0);
}

TEST(Map, CutsAnEstimateThatDiverges) {
  Chart map = circle_map();
  map.series[2].points.push_back({1e9, 1e9});
  const std::string svg = svg_of(map);
  EXPECT_THAT(svg, HasSubstr("1.25 cm/m · leaves the picture"));
  EXPECT_LT(svg.size(), 100'000U);
}

TEST(Map, LimitsTheSizeOfALongDrive) {
  Chart map = circle_map();
  auto& points = map.series[2].points;
  for (int i = 0; i < 200'000; ++i)
    points.push_back({1.05 * std::cos(3.14e-5 * i), 1.05 * std::sin(3.14e-5 * i)});
  EXPECT_LT(svg_of(map).size(), 60'000U);
}

TEST(PictureFile, HasTheFormatOfItsFileExtension) {
  const Scratch scratch;
  write_picture(scratch.path("a.svg"), std::array{draw(circle_map())});
  EXPECT_EQ(contents(scratch.path("a.svg")), svg_of(circle_map()));
  EXPECT_THAT(
      message_of([&] { write_picture(scratch.path("a.jpg"), std::array{draw(circle_map())}); }),
      HasSubstr("a.jpg: pictures end in .svg or .png"));
  EXPECT_THAT(
      message_of([&] { write_picture("/nonexistent/a.png", std::array{draw(circle_map())}); }),
      HasSubstr("/nonexistent/a.png: cannot be written"));
}

TEST(PictureFile, SaysThatPngNeedsAConverter) {
  const Scratch scratch;
  const char* inherited = std::getenv("PATH");
  const std::string path = inherited != nullptr ? inherited : "";
  ::setenv("PATH", scratch.path("").c_str(), 1);
  const std::string error =
      message_of([&] { write_picture(scratch.path("a.png"), std::array{draw(circle_map())}); });
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(error, HasSubstr("install librsvg2-bin, or give a .svg file"));
}

}  // namespace
}  // namespace odomd::tools::chart::charts_test
