// Writers end and are followed by others: staleness, re-attachment, inheritance.
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_succession {
namespace {

constexpr std::int64_t slow_ns = 1'000'000'000;  // stale after 4 s: the test is not that slow
constexpr std::int64_t fast_ns = 1'000'000;      // stale after 4 ms

class Succession : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  SegmentSettings settings{.name = path, .slots = 64};
};

TEST_F(Succession, SilenceOfFourPeriodsIsStaleAndTheLastPoseIsGiven) {
  Writer writer(settings, test_info(slow_ns));
  const ClientPointer client = open_client(path);
  publish_patterned(writer, 1, 1);
  odom_pose pose{};
  EXPECT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
  // Half a period clear of the limit: the coarse clock of a busy machine lags by some of its ticks.
  writer.set_heartbeat(now_ns() - 4 * slow_ns - slow_ns / 2);
  pose = {};
  EXPECT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_STALE);
  EXPECT_EQ(pose.tick, 1U);
  odom_view view{};
  EXPECT_EQ(odom_begin(client.get(), &view), ODOM_STALE);
  EXPECT_TRUE(odom_validate(&view));
  writer.set_heartbeat(now_ns());
  EXPECT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
}

TEST_F(Succession, AHeartbeatOnAnotherClockIsStale) {
  Writer writer(settings, test_info(slow_ns));
  const ClientPointer client = open_client(path);
  publish_patterned(writer, 1, 1);
  odom_pose pose{};
  for (const std::int64_t heartbeat : {now_ns() + 60 * slow_ns, INT64_MIN, INT64_MAX}) {
    writer.set_heartbeat(heartbeat);
    EXPECT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_STALE) << heartbeat;
  }
}

TEST_F(Succession, AClientGoesOverToTheSuccessorOnceItPublishes) {
  ClientPointer client;
  {
    Writer writer(settings, test_info(fast_ns));
    publish_patterned(writer, 100, now_ns());
    client = open_client(path);
    writer.set_heartbeat(now_ns() - 10 * fast_ns);
  }
  Writer successor(settings, test_info(slow_ns));
  odom_pose pose{};
  const std::int64_t until = now_ns() + 10 * fast_ns;
  while (now_ns() < until) {
    ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_STALE);
    ASSERT_EQ(pose.tick, 100U);
  }
  publish_patterned(successor, 3, now_ns());
  // The wait takes it for the newer one although its tick is lower.
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 5 * slow_ns), ODOM_OK);
  EXPECT_EQ(pose.tick, 3U);
  odom_info info{};
  EXPECT_EQ(odom_get_info(client.get(), &info, sizeof info), ODOM_OK);
  EXPECT_EQ(info.instance_id, successor.info().instance_id);
}

TEST_F(Succession, ARemovedNameLeavesTheLastPose) {
  ClientPointer client;
  {
    Writer writer(settings, test_info(fast_ns));
    publish_patterned(writer, 1, 5);
    client = open_client(path);
    writer.set_heartbeat(now_ns() - 10 * fast_ns);
  }
  unlink(path.c_str());
  odom_pose pose{};
  EXPECT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_STALE);
  EXPECT_TRUE(is_whole(pose));
  // Silence, not a time-out, is what a wait reports, and it gives the last pose.
  odom_pose waited{};
  EXPECT_EQ(odom_wait(client.get(), &waited, sizeof waited, 1'000'000), ODOM_STALE);
  EXPECT_EQ(waited.tick, 1U);
}

TEST_F(Succession, TheSuccessorInheritsTheLastPose) {
  EXPECT_FALSE(Writer(settings, test_info()).predecessor().has_value());
  std::uint64_t instance = 0;
  {
    Writer writer(settings, test_info());
    EXPECT_FALSE(writer.predecessor().has_value());  // published nothing
    publish_patterned(writer, 7, 70);
    publish_patterned(writer, 9, 90);
    instance = writer.info().instance_id;
  }
  const Writer successor(settings, test_info());
  ASSERT_TRUE(successor.predecessor().has_value());
  EXPECT_EQ(successor.predecessor()->pose.tick, 9U);
  EXPECT_TRUE(is_whole(successor.predecessor()->pose, &successor.predecessor()->details));
  EXPECT_EQ(successor.predecessor()->info.instance_id, instance);
  EXPECT_NE(successor.info().instance_id, instance);
}

TEST_F(Succession, AClaimAloneTouchesNothing) {
  {
    Writer writer(settings, test_info());
    publish_patterned(writer, 7, 70);
  }
  {
    const Claim claim(settings);
    ASSERT_TRUE(claim.predecessor().has_value());
    EXPECT_EQ(claim.predecessor()->pose.tick, 7U);
    EXPECT_THROW(Claim{settings}, std::invalid_argument) << "claimed already";
  }
  EXPECT_EQ(Claim(settings).predecessor()->pose.tick, 7U) << "whoever gave up has lost nothing";
  Claim claim(settings);
  const Writer writer(std::move(claim), test_info());
  EXPECT_THROW(Claim{settings}, std::invalid_argument) << "the writer holds on to it";
}

TEST_F(Succession, AStrangerLeavesNothingToInherit) {
  if (geteuid() != 0) {
    std::cout << "not run: 1 (needs root to give a file to a stranger)\n";
    return;
  }
  {
    Writer writer(settings, test_info());
    publish_patterned(writer, 7, 70);
  }
  ASSERT_EQ(chown(path.c_str(), 54321, static_cast<gid_t>(-1)), 0);
  EXPECT_FALSE(Writer(settings, test_info()).predecessor().has_value());
}

}  // namespace
}  // namespace odomd::shm::testing::test_succession
