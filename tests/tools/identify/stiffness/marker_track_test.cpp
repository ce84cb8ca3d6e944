#include "tools/identify/stiffness/film.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::marker_track_test {
namespace {

using testing::HasSubstr;

TEST(MarkerTrack, ReadsColumnsByNameInAnyOrderAndCountsGaps) {
  const Scratch scratch;
  const auto file = scratch.write("a.csv",
                                  "# made by hand\n"
                                  "t,note,x_rear,y_rear,x_front,y_front\n"
                                  "0.0,a,1,2,3,4\n"
                                  "0.1,b,,,3,4\n"
                                  "\n"
                                  "0.2,c,1.5,2.5,3.5,4.5\r\n");
  const MarkerTrack track = read_marker_track(file);
  ASSERT_EQ(track.frames.size(), 2U);
  EXPECT_EQ(track.gaps, 1U);
  EXPECT_EQ(track.frames[1].t_ns, 200'000'000);
  EXPECT_EQ(track.frames[1].front, Plane(3.5, 4.5));
  EXPECT_EQ(track.frames[1].rear, Plane(1.5, 2.5));
}

TEST(MarkerTrack, ReadsATableThatBeginsWithAByteOrderMark) {
  const Scratch scratch;
  const auto file =
      scratch.write("bom.csv", "\xEF\xBB\xBFt,x_front,y_front,x_rear,y_rear\n0,1,2,3,4\n");
  EXPECT_EQ(read_marker_track(file).frames.size(), 1U);
}

TEST(MarkerTrack, OfEndlessLinesIsRefusedBeforeItFillsTheMemory) {
  const Scratch scratch;
  const auto file = scratch.write("endless.csv", std::string(200'000, '0'));
  EXPECT_THAT(message_of([&] { (void)read_marker_track(file); }),
              HasSubstr("endless.csv:1: the line is longer than 64 KiB"));
  EXPECT_THAT(message_of([] { (void)read_marker_track("/dev/zero"); }), HasSubstr("is a device"));
}

TEST(MarkerTrack, ReadsATableAMarkerAsTrackingProgramsExportThem) {
  const Scratch scratch;
  // Tabs, a title above the headings, exponents; and semicolons with decimal commas.
  const auto front = scratch.write("front.txt",
                                   "mass_A\n"
                                   "t\tx\ty\n"
                                   "0.000E0\t1.5E1\t2.0E0\n"
                                   "3.334E-2\t1.6E1\t2.1E0\n"
                                   "6.667E-2\t1.7E1\t2.2E0\n");
  const auto rear = scratch.write("rear.txt",
                                  "\"t (s)\";\"x (px)\";\"y (px)\"\n"
                                  "0,000;5,5;2\n"
                                  "0,06667;7,5;2,25\n");
  const MarkerTrack track = read_marker_tracks(front, rear);
  ASSERT_EQ(track.frames.size(), 2U);
  EXPECT_EQ(track.gaps, 1U);
  EXPECT_EQ(track.frames[1].t_ns, 66'670'000);
  EXPECT_EQ(track.frames[1].front, Plane(17.0, 2.2));
  EXPECT_EQ(track.frames[1].rear, Plane(7.5, 2.25));
}

TEST(MarkerTrack, CountsFramesWhereAsked) {
  const Scratch scratch;
  const auto file =
      scratch.write("a.csv", "t;x_front;y_front;x_rear;y_rear\n0;1;2;3;4\n120;1;2;3;4\n");
  EXPECT_EQ(read_marker_track(file, {.frames_per_second = 240.0}).frames[1].t_ns, 500'000'000);
}

TEST(MarkerTrack, BadInputIsNamedByLineAndColumn) {
  const Scratch scratch;
  const std::string head = "t,x_front,y_front,x_rear,y_rear\n0,1,2,3,4\n";
  struct Case {
    std::string text;
    const char* says;
    FilmTime time = {};
  };
  const Case cases[]{{head + "0,1,2,3,4\n", "bad.csv:3: column \"t\""},
                     {head + "-1,1,2,3,4\n", "sort the rows"},
                     {head + "1,nan,2,3,4\n", "bad.csv:3: column \"x_front\""},
                     {head + "1,1,2,3,x\n", "column \"y_rear\""},
                     {head + "x,1,2,3,4\n", "not a time"},
                     {"t,x,y\n0,1,2\n", "no column \"x_front\""},
                     {"0,1,2,3,4\n", "no column \"t\""},
                     {"nothing\n", "contains no row"},
                     {"", "contains no row"},
                     {head + "1.5,1,2,3,4\n", "not a frame number", {.frames_per_second = 50.0}}};
  for (const auto& [text, says, time] : cases) {
    const auto file = scratch.write("bad.csv", text);
    EXPECT_THAT(message_of([&] { (void)read_marker_track(file, time); }), HasSubstr(says)) << text;
  }
}

TEST(MarkerTrack, TracksOfDifferentFilmsAreRefused) {
  const Scratch scratch;
  const auto a = scratch.write("a.txt", "0 1 2\n1 1 2\n");
  const auto b = scratch.write("b.txt", "0.5 1 2\n1.5 1 2\n");
  EXPECT_THROW((void)read_marker_tracks(a, b), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::tools::marker_track_test
