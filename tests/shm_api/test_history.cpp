// odom_at: the pose at a past time, with missed ticks, resets and the ends of the history.
#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_history {
namespace {

constexpr std::uint64_t slots = 64;

class History : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  Writer writer{{.name = path, .slots = slots}, test_info()};
  ClientPointer client = open_client(path);
  odom_pose pose{};

  void publish(const odom_pose& p) { writer.publish(p, odom_details{}); }
  void publish_moving(std::uint64_t first, std::uint64_t last) {
    for (std::uint64_t tick = first; tick <= last; ++tick) publish(moving_pose(tick));
  }
  // Whether the writer is fresh does not matter here: a slow test may exceed 20 ms.
  odom_status at(std::int64_t time_ns) {
    const odom_status status = odom_at(client.get(), time_ns, &pose, sizeof pose);
    return status == ODOM_STALE ? ODOM_OK : status;
  }
  void expect_at(const std::vector<std::pair<std::int64_t, odom_status>>& expected) {
    for (const auto& [time_ns, status] : expected) EXPECT_EQ(at(time_ns), status) << time_ns;
  }
};

constexpr double sideslip = 0.3;

// A circle at constant speed: v = 2 m/s, yaw rate 3 rad/s.
odom_pose circling_pose(std::uint64_t tick) {
  const auto time_ns = static_cast<std::int64_t>(tick) * period_ns;
  const double course = 3.0 * static_cast<double>(time_ns) * 1e-9;
  const double x = 2.0 / 3.0 * std::sin(course);
  const double y = -2.0 / 3.0 * std::cos(course);
  const auto number = static_cast<double>(tick);
  return {.tick = tick,
          .time_ns = time_ns,
          .x = x,
          .y = y,
          .yaw = course - sideslip,
          .odom_x = x + 10.0,
          .odom_y = y,
          .odom_yaw = course - sideslip,
          .vx = 2.0 * std::cos(sideslip),
          .vy = 2.0 * std::sin(sideslip),
          .yaw_rate = 3.0,
          .accel_y = number,
          .covariance = {number},
          .mode = ODOM_TRACKING};
}

double distance_from_circle(const odom_pose& p) {
  const double course = 3.0 * static_cast<double>(p.time_ns) * 1e-9;
  return std::hypot(p.x - 2.0 / 3.0 * std::sin(course), p.y + 2.0 / 3.0 * std::cos(course));
}

TEST_F(History, EveryTickIsFoundExactlyAndBothEndsAreReported) {
  EXPECT_EQ(at(5), ODOM_NO_POSE);
  publish_moving(5, 9);
  expect_at({{5 * period_ns, ODOM_OK}, {5 * period_ns - 1, ODOM_TOO_OLD}});
  publish_moving(10, 200);
  for (std::uint64_t tick = 200 - slots + 1; tick <= 200; ++tick) {
    ASSERT_EQ(at(static_cast<std::int64_t>(tick) * period_ns), ODOM_OK) << tick;
    EXPECT_TRUE(is_same(pose, moving_pose(tick)));
  }
  const auto oldest = static_cast<std::int64_t>(200 - slots + 1) * period_ns;
  expect_at({{200 * period_ns + 1, ODOM_TOO_NEW},
             {INT64_MAX, ODOM_TOO_NEW},
             {oldest - 1, ODOM_TOO_OLD},
             {0, ODOM_TOO_OLD},
             {INT64_MIN, ODOM_TOO_OLD}});
}

TEST_F(History, BetweenTicksThePoseIsInterpolated) {
  for (std::uint64_t tick = 1; tick <= 100; ++tick) publish(circling_pose(tick));
  for (std::int64_t t = 60 * period_ns; t < 99 * period_ns; t += 777'777) {
    ASSERT_EQ(at(t), ODOM_OK);
    EXPECT_EQ(pose.time_ns, t);
    EXPECT_EQ(pose.tick, static_cast<std::uint64_t>(t / period_ns));
    EXPECT_LT(distance_from_circle(pose), 1e-7);
    EXPECT_NEAR(pose.odom_x - 10.0, pose.x, 1e-9);
    EXPECT_NEAR(pose.yaw, 3e-9 * static_cast<double>(t) - sideslip, 1e-9);
    EXPECT_NEAR(pose.accel_y, static_cast<double>(t) / period_ns, 1e-9);
    EXPECT_NEAR(pose.covariance[0], static_cast<double>(t) / period_ns, 1e-9);
  }
}

TEST_F(History, MissedTicksAreBridged) {
  // Ticks 61 to 79 are missed, 100 ms between ticks 60 and 80; then every other tick.
  for (std::uint64_t tick = 1; tick <= 100; ++tick)
    if (tick <= 60 || tick >= 80) publish(circling_pose(tick));
  for (std::int64_t t = 55 * period_ns; t < 99 * period_ns; t += 1'234'567) {
    ASSERT_EQ(at(t), ODOM_OK) << t;
    EXPECT_LT(distance_from_circle(pose), 20e-6);
  }
  ASSERT_EQ(at(70 * period_ns), ODOM_OK);
  EXPECT_EQ(pose.tick, 60U);
  for (std::uint64_t tick = 102; tick <= 200; tick += 2) publish(circling_pose(tick));
  for (std::int64_t t = 150 * period_ns; t <= 200 * period_ns; t += 999'999) {
    ASSERT_EQ(at(t), ODOM_OK) << t;
    EXPECT_LT(distance_from_circle(pose), 1e-6);
  }
}

TEST_F(History, ALongerGapIsNotBridged) {
  for (const std::uint64_t tick : {1U, 2U, 23U}) publish(moving_pose(tick));
  expect_at({{2 * period_ns, ODOM_OK},
             {2 * period_ns + 1, ODOM_GAP},
             {23 * period_ns - 1, ODOM_GAP},
             {23 * period_ns, ODOM_OK}});
  // A gap longer than the ring hides all earlier poses.
  constexpr std::uint64_t after = 23 + 3 * slots;
  publish(moving_pose(after));
  expect_at(
      {{23 * period_ns, ODOM_TOO_OLD}, {static_cast<std::int64_t>(after) * period_ns, ODOM_OK}});
}

TEST_F(History, UpToAResetTheEarlierPoseIsPredicted) {
  for (std::uint64_t tick = 1; tick <= 10; ++tick) {
    odom_pose p = circling_pose(tick);
    if (tick >= 6) {
      p.reset_count = 1;
      p.x += 100.0;
    }
    publish(p);
  }
  for (const std::int64_t t : {5 * period_ns + 1, 5 * period_ns + 2'345'678, 6 * period_ns - 1}) {
    ASSERT_EQ(at(t), ODOM_OK) << t;
    EXPECT_EQ(pose.time_ns, t);
    EXPECT_EQ(pose.tick, 5U);
    EXPECT_EQ(pose.reset_count, 0U);
    EXPECT_LT(distance_from_circle(pose), 1e-7);
    EXPECT_NEAR(pose.odom_x - 10.0, pose.x, 1e-9);
    EXPECT_GE(pose.covariance[0], 5.0);
  }
  for (const std::int64_t t : {6 * period_ns, 6 * period_ns + 1}) {
    EXPECT_EQ(at(t), ODOM_OK);
    EXPECT_EQ(pose.reset_count, 1U);
    EXPECT_GT(pose.x, 99.0);
  }
}

TEST_F(History, AResetAfterMissedTicksIsPredictedTo) {
  publish(circling_pose(10));
  odom_pose p = circling_pose(29);
  p.reset_count = 1;
  p.x += 100.0;
  publish(p);
  ASSERT_EQ(at(28 * period_ns), ODOM_OK);
  EXPECT_LT(distance_from_circle(pose), 20e-6);
  p = circling_pose(50);
  p.reset_count = 2;
  publish(p);
  EXPECT_EQ(at(40 * period_ns), ODOM_GAP);
}

TEST_F(History, NothingIsPredictedFromAnInitialisingPose) {
  odom_pose p = circling_pose(1);
  p.mode = ODOM_INITIALISING;
  publish(p);
  p = circling_pose(2);
  p.reset_count = 1;
  publish(p);
  expect_at({{period_ns, ODOM_OK}, {period_ns + 1, ODOM_RESET}, {2 * period_ns, ODOM_OK}});
}

TEST_F(History, YawTakesTheShorterWay) {
  odom_pose a = moving_pose(1);
  odom_pose b = moving_pose(2);
  a.yaw = 3.1;
  b.yaw = -3.1;  // a restarted daemon may count its turns from zero
  publish(a);
  publish(b);
  ASSERT_EQ(at(period_ns * 3 / 2), ODOM_OK);
  EXPECT_NEAR(pose.yaw, 3.14159265, 1e-6);
}

TEST_F(History, TimeAfterSilenceIsStale) {
  publish_moving(1, 10);
  writer.set_heartbeat(now_ns() - 5 * period_ns);
  EXPECT_EQ(odom_at(client.get(), 5 * period_ns, &pose, sizeof pose), ODOM_STALE);
  EXPECT_EQ(pose.tick, 5U);
}

}  // namespace
}  // namespace odomd::shm::testing::test_history
