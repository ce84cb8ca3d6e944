// The C++ header over libodom.
#include <odom/odom.hpp>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_wrapper {
namespace {

class Wrapper : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  Writer writer{{.name = path, .slots = 64}, test_info(1'000'000'000)};

  void publish(std::uint64_t tick) { writer.publish(moving_pose(tick), odom_details{}); }
};

TEST_F(Wrapper, FailedOpenHasAReasonAndEmptyClientIsInvalid) {
  const auto opened = odom::Client::open(directory.file("none").c_str());
  EXPECT_FALSE(opened);
  EXPECT_FALSE(opened.has_value());
  EXPECT_EQ(opened.status, ODOM_NO_SEGMENT);
  EXPECT_STREQ(opened.message(), "no such segment: is odomd running?");
  odom::Client client;
  EXPECT_EQ(client.latest().status, ODOM_INVALID);
  EXPECT_EQ(client.read_in_place([](odom::View) {}), ODOM_INVALID);
}

TEST_F(Wrapper, ResultIsTrueOnlyIfFresh) {
  auto client = odom::Client::open(path.c_str());
  ASSERT_TRUE(client);
  EXPECT_EQ(client->latest().status, ODOM_NO_POSE);
  publish(5);
  const auto fresh = client->latest();
  ASSERT_TRUE(fresh);
  EXPECT_EQ(fresh->tick, 5U);
  writer.set_heartbeat(now_ns() - 5'000'000'000);
  const auto stale = client->latest();
  EXPECT_FALSE(stale);
  ASSERT_TRUE(stale.has_value());
  EXPECT_EQ((*stale).tick, 5U);
}

TEST_F(Wrapper, InPlaceAccessorsReadTheirFields) {
  odom_pose pose = moving_pose(5);
  pose.y = 2.0;
  pose.yaw = 3.0;
  pose.odom_y = 4.0;
  pose.yaw_rate = 6.0;
  pose.steering = 7.0;
  pose.conditions = ODOM_COND_RESTARTED;
  pose.reset_count = 8;
  pose.health = 9;
  writer.publish(pose, odom_details{});
  auto client = odom::Client::open(path.c_str());
  odom_pose seen{};
  ASSERT_EQ(client->read_in_place([&](const odom::View& view) {
    seen = {.tick = view.tick(),
            .time_ns = view.time_ns(),
            .x = view.x(),
            .y = view.y(),
            .yaw = view.yaw(),
            .odom_x = view.odom_x(),
            .odom_y = view.odom_y(),
            .odom_yaw = view.odom_yaw(),
            .vx = view.vx(),
            .vy = view.vy(),
            .yaw_rate = view.yaw_rate(),
            .steering = view.steering(),
            .mode = static_cast<std::uint32_t>(view.mode()),
            .conditions = view.conditions(),
            .reset_count = view.reset_count(),
            .health = view.health()};
  }),
            ODOM_OK);
  EXPECT_TRUE(is_same(seen, pose));
}

TEST_F(Wrapper, InPlaceReadingGivesUpAfterThreeAttempts) {
  publish(1);
  auto client = odom::Client::open(path.c_str());
  int calls = 0;
  std::uint64_t tick = 1;
  EXPECT_EQ(client->read_in_place([&](const odom::View&) {
    ++calls;
    for (int i = 0; i < 64; ++i) publish(++tick);
  }),
            ODOM_BUSY);
  EXPECT_EQ(calls, 3);
}

TEST_F(Wrapper, PredictionCoversHistoryTo100MsAhead) {
  Writer fast({.name = directory.file("fast"), .slots = 64}, test_info(period_ns));
  for (std::uint64_t tick = 1; tick <= 10; ++tick) fast.publish(moving_pose(tick), odom_details{});
  auto client = odom::Client::open(directory.file("fast").c_str());
  for (const std::int64_t t : {7 * period_ns, 10 * period_ns, 15 * period_ns, 30 * period_ns}) {
    const auto pose = client->predict(t);
    ASSERT_TRUE(pose.has_value()) << t << ' ' << pose.message();
    EXPECT_EQ(pose->time_ns, t);
    EXPECT_NEAR(pose->x, 1e-9 * static_cast<double>(t), 1e-9);
  }
  EXPECT_EQ(client->predict(31 * period_ns).status, ODOM_TOO_NEW);
}

TEST_F(Wrapper, MovedClientWorks) {
  publish(1);
  writer.set_realtime_offset(100);
  writer.count_missed(4);
  auto opened = odom::Client::open(path.c_str());
  odom::Client client = std::move(*opened);
  EXPECT_EQ(client.info()->slots, 64U);
  EXPECT_EQ(client.beat()->missed, 4U);
  EXPECT_EQ(*client.to_clock(ODOM_CLOCK_REALTIME, 5), 105);
  EXPECT_EQ(client.latest_details()->pose.tick, 1U);
  EXPECT_EQ(client.at(period_ns)->tick, 1U);
  const auto first = client.latest();
  publish(2);
  const auto next = client.wait(*first, std::chrono::seconds(60));
  ASSERT_TRUE(next);
  EXPECT_EQ(next->tick, 2U);
  EXPECT_EQ(client.wait(*next, std::chrono::milliseconds(1)).status, ODOM_TIMEOUT);
}

}  // namespace
}  // namespace odomd::shm::testing::test_wrapper
