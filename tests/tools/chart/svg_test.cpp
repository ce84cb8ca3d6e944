#include "tools/chart/svg.hpp"

#include <gtest/gtest.h>

namespace odomd::tools::svg_test {
namespace {

TEST(Escaped, LeavesLettersAndHidesWhatIsMarkup) {
  EXPECT_EQ(svg::escaped("a<b>&\"c\" ψ±3√S 🚗"), "a&lt;b&gt;&amp;&quot;c&quot; ψ±3√S 🚗");
  EXPECT_EQ(svg::escaped("two\nlines\x01"), "two lines ");
}

TEST(Escaped, ReplacesWhatIsNoUtf8) {
  EXPECT_EQ(svg::escaped("lap\xff.csv"), "lap\uFFFD.csv");
  EXPECT_EQ(svg::escaped("caf\xe9"), "caf\uFFFD");                // Latin-1
  EXPECT_EQ(svg::escaped("\xc0\xaf"), "\uFFFD\uFFFD");            // longer than needed
  EXPECT_EQ(svg::escaped("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");  // a surrogate
  EXPECT_EQ(svg::escaped("\xf4\x90\x80\x80").size(), 4 * 3U);     // beyond U+10FFFF
  EXPECT_EQ(svg::escaped("cut \xe2\x82"), "cut \uFFFD\uFFFD");
}

}  // namespace
}  // namespace odomd::tools::svg_test
