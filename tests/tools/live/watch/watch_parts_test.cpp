// odom watch: the parts of its pages, and the keys.
#include "tests/gtest.hpp"
#include "tools/live/line.hpp"
#include "tools/live/watch/pictures.hpp"
#include "tools/live/watch/terminal.hpp"

namespace odomd::tools::watch::watch_parts_test {
namespace {

TEST(WatchHistogram, ShowsEveryBucketThatIsNotEmpty) {
  std::uint64_t histogram[ODOM_HISTOGRAM_BUCKETS]{};
  histogram[0] = 1;
  histogram[8] = 1'000'000;
  histogram[63] = 1;
  const auto rows = bars(histogram, 1, 2, Glyphs::ascii);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0], "        #" + std::string(55, ' '));
  EXPECT_EQ(rows[1], ".       #" + std::string(54, ' ') + ".");
  const std::uint64_t empty[ODOM_HISTOGRAM_BUCKETS]{};
  EXPECT_EQ(bars(empty, 2, 1, Glyphs::ascii).front(), std::string(32, ' '));
  // Bucket i holds [2^((i-1)/4), 2^(i/4)) us: 1 us is in bucket 1, 10 us in 14, 1 ms in 40.
  EXPECT_EQ(axis(1, Glyphs::ascii), " 1 us         10           100          1 ms          10 ms");
}

TEST(WatchLine, IsCutAndFilledByCharacters) {
  const Line line{{"±12", Style::strong}, {"°C"}};
  EXPECT_EQ(as_text(fitted(line, 4)), "±12°");
  EXPECT_EQ(width(fitted(line, 9)), 9U);
  EXPECT_EQ(as_text(justified({{"left"}}, {{"right"}}, 12)), "left   right");
  EXPECT_EQ(as_text(justified({{"left"}}, {{"right"}}, 10)), "left");
}

TEST(WatchLine, HasColoursOnlyWhereTheyAreWanted) {
  const Line line{{"a", Style::good}, {"b"}, {"c", Style::bad}};
  EXPECT_EQ(as_ansi(line, Colour::on), "\x1b[32ma\x1b[0mb\x1b[1;31mc\x1b[0m");
  EXPECT_EQ(as_ansi(line, Colour::off), "ab\x1b[1mc\x1b[0m");
}

TEST(WatchKeys, AreReadFromWhatATerminalSends) {
  EXPECT_THAT(keys_in("pq?"), ElementsAre(Key::pause, Key::quit, Key::list_keys));
  EXPECT_THAT(keys_in("\x1b[A\x1bOB\x1b[5~\x1b[6~"),
              ElementsAre(Key::up, Key::down, Key::page_up, Key::page_down));
  EXPECT_THAT(keys_in("\x1b[H\x1b[4~j"), ElementsAre(Key::home, Key::end, Key::down));
  EXPECT_THAT(keys_in("\x1b[1;5C\x1b[200~x\x1b"), IsEmpty());
  EXPECT_THAT(keys_in("\x1b["), IsEmpty());
}

}  // namespace
}  // namespace odomd::tools::watch::watch_parts_test
