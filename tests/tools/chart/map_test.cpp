#include "tools/chart/map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/tools/markup.hpp"
#include "tests/tools/scratch.hpp"

namespace odomd::tools::chart::map_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

Map circle_map() {
  Map map;
  map.title = "R&D <lap>";
  map.reference = {"reference", "6.3 m", {}, {}};
  Trace trace{"paper", "1.25 cm/m", {}, {}};
  for (int i = 0; i <= 100; ++i) {
    const double a = 0.0628 * i;
    map.reference.points.push_back({std::cos(a), std::sin(a)});
    trace.points.push_back({1.05 * std::cos(a), 1.05 * std::sin(a)});
  }
  trace.end_ellipse = Ellipse{trace.points.back(), {0.01, 0.0, 0.0025}};
  map.estimates.push_back(trace);
  return map;
}

std::string svg_of(const Map& map) {
  return as_svg(std::array{draw(map)});
}

TEST(Map, IsAnSvgWithEscapedWordsAndItsLegend) {
  const std::string svg = svg_of(circle_map());
  EXPECT_THAT(svg, StartsWith("<svg xmlns="));
  EXPECT_EQ(markup_fault(svg), "");
  EXPECT_THAT(svg, HasSubstr("R&amp;D &lt;lap&gt;"));
  EXPECT_THAT(svg, HasSubstr("1.25 cm/m"));
  EXPECT_THAT(svg, HasSubstr("<ellipse"));
  EXPECT_THAT(svg, Not(HasSubstr("leaves the picture")));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(Map, HasEqualAxes) {
  // A unit circle is as wide as high: the reference's extremes in the path data.
  const std::string svg = svg_of(circle_map());
  const auto start = svg.find("<path d=\"M", svg.find("<svg x=")) + 10;
  std::istringstream data{svg.substr(start, svg.find('"', start) - start)};
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9, x = 0.0, y = 0.0;
  char separator = 0;
  while (data >> x >> y) {
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
    data >> separator;
  }
  EXPECT_GT(right - left, 500.0);
  EXPECT_NEAR(right - left, bottom - top, 2.0);
}

TEST(Map, CutsAnEstimateThatRunsAway) {
  Map map = circle_map();
  map.estimates[0].points.push_back({1e9, 1e9});
  const std::string svg = svg_of(map);
  EXPECT_THAT(svg, HasSubstr("leaves the picture"));
  EXPECT_LT(svg.size(), 100'000U);
}

TEST(Map, OfACarThatStandsIsStillAPicture) {
  Map map;
  map.reference = {"reference", "", {{2.0, 3.0}, {2.0, 3.0}}, {}};
  EXPECT_THAT(svg_of(map), Not(::testing::AnyOf(HasSubstr("nan"), HasSubstr("inf"))));
}

TEST(PictureFile, IsSvgOrPngByItsEnding) {
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

TEST(PictureFile, PngNeedsAConverterAndSaysSo) {
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
}  // namespace odomd::tools::chart::map_test
