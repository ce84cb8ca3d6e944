// odom watch: the parts of its pages, and the keys.
#include <limits>

#include "tests/gtest.hpp"
#include "tools/live/line.hpp"
#include "tools/live/watch/page.hpp"
#include "tools/live/watch/terminal.hpp"

namespace odomd::tools::watch::watch_parts_test {
namespace {

odom_pose pose_at(double x, double y) {
  odom_pose pose{};
  pose.x = x;
  pose.y = y;
  pose.mode = ODOM_TRACKING;
  return pose;
}

TEST(WatchMap, DrawsWhatIsNotFiniteOrHugeWithoutHarm) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const Trail trail;
  for (const double value : {inf, -inf, 1e300, -1e300, std::nan("")}) {
    odom_pose pose = pose_at(1.0, 1.0);
    pose.covariance[0] = value;
    EXPECT_EQ(draw_map(trail, pose, 30, 8).size(), 8U);
    pose.x = value;
    EXPECT_EQ(draw_map(trail, pose, 30, 8).size(), 8U);
  }
}

TEST(WatchMap, StandsStillWhileTheCarMovesALittle) {
  Trail trail;
  for (int i = 0; i <= 120; ++i) trail.take(pose_at(0.02 * i, 0.05 * i), 1);
  const auto scale_of = [&trail](double y) {
    return as_text(draw_map(trail, pose_at(1.2, y), 40, 10).back());
  };
  EXPECT_EQ(scale_of(3.0), scale_of(3.3));
}

TEST(WatchMap, GivesTheAxesOfAnEllipse) {
  const Ellipse flat = ellipse_of({0.04, 0.0, 0.01}, 3.0);
  EXPECT_NEAR(flat.long_half_axis, 0.6, 1e-12);
  EXPECT_NEAR(flat.short_half_axis, 0.3, 1e-12);
  EXPECT_NEAR(flat.direction, 0.0, 1e-12);
  EXPECT_NEAR(ellipse_of({0.02, 0.01, 0.02}, 1.0).direction, std::atan(1.0), 1e-12);
  EXPECT_NEAR(ellipse_of({0.01, 0.0, 0.04}, 1.0).direction, 2.0 * std::atan(1.0), 1e-12);
}

TEST(WatchTrail, KeepsTheDriveWhileTheCarStandsAndBreaksAtALeap) {
  Trail trail;
  odom_pose pose = pose_at(0.0, 0.0);
  trail.take(pose, 1);
  trail.take(pose, 1);
  EXPECT_EQ(trail.points().size(), 1U);
  pose.x += 1.0;
  trail.take(pose, 1);
  pose.x += 5.0;
  pose.jump_x = 5.0;
  pose.reset_count = 1;
  trail.take(pose, 1);
  pose.x += 5.0;
  trail.take(pose, 2);  // another daemon
  std::vector<bool> joined;
  for (const TrailPoint& point : trail.points()) joined.push_back(point.joined);
  EXPECT_THAT(joined, ElementsAre(false, true, false, false));
  for (int i = 0; i < 2000; ++i) {
    pose.x += 0.01;
    trail.take(pose, 2);
  }
  EXPECT_EQ(trail.points().size(), Trail::longest);
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
  EXPECT_THAT(keys_in("pq ?"), ElementsAre(Key::pause, Key::quit, Key::pause));
  EXPECT_THAT(keys_in("\x1b[A\x1bOB\x1b[5~\x1b[6~"),
              ElementsAre(Key::up, Key::down, Key::page_up, Key::page_down));
  EXPECT_THAT(keys_in("\x1b[1;5C\x1b[200~x\x1b"), IsEmpty());
  EXPECT_THAT(keys_in("\x1b["), IsEmpty());
}

}  // namespace
}  // namespace odomd::tools::watch::watch_parts_test
