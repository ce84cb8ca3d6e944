// Writers end and are replaced: staleness, re-attachment, inheritance.
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_succession {
namespace {

constexpr std::int64_t slow_ns = 1'000'000'000;  // stale after 4 s, longer than the test takes

class Succession : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  SegmentSettings settings{.name = path, .slots = 64};
};

TEST_F(Succession, FourSilentPeriodsAreStaleWithTheLastPose) {
  Writer writer(settings, test_info(slow_ns));
  const ClientPointer client = open_client(path);
  publish_patterned(writer, 1, 1);
  EXPECT_EQ(latest(client), Latest(ODOM_OK, 1));
  // Half a period beyond the limit: the coarse clock of a busy machine may lag by some of its
  // ticks.
  writer.set_heartbeat(now_ns() - 4 * slow_ns - slow_ns / 2);
  EXPECT_EQ(latest(client), Latest(ODOM_STALE, 1));
  odom_view view{};
  EXPECT_EQ(odom_begin(client.get(), &view), ODOM_STALE);
  EXPECT_TRUE(odom_validate(&view));
  writer.set_heartbeat(now_ns());
  EXPECT_EQ(latest(client), Latest(ODOM_OK, 1));
  // On another clock.
  for (const std::int64_t heartbeat : {now_ns() + 60 * slow_ns, INT64_MIN, INT64_MAX}) {
    writer.set_heartbeat(heartbeat);
    EXPECT_EQ(latest(client), Latest(ODOM_STALE, 1)) << heartbeat;
  }
}

TEST_F(Succession, ClientSwitchesToAPublishingSuccessor) {
  const ClientPointer client = client_of_dead_writer(settings, 100);
  Writer successor(settings, test_info(slow_ns));
  const std::int64_t until = now_ns() + 10'000'000;
  while (now_ns() < until) ASSERT_EQ(latest(client), Latest(ODOM_STALE, 100));
  odom_pose pose{};
  odom_latest(client.get(), &pose, sizeof pose);
  publish_patterned(successor, 3, now_ns());
  // The wait accepts this pose as newer although its tick is lower.
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 5 * slow_ns), ODOM_OK);
  EXPECT_EQ(pose.tick, 3U);
  EXPECT_EQ(info_of(client).instance_id, successor.info().instance_id);
}

TEST_F(Succession, ARemovedNameLeavesTheLastPose) {
  const ClientPointer client = client_of_dead_writer(settings, 1);
  unlink(path.c_str());
  odom_pose pose{};
  EXPECT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_STALE);
  EXPECT_TRUE(is_whole(pose));
  // A wait reports a silent daemon, not a time-out, and returns the last pose.
  odom_pose waited{};
  EXPECT_EQ(odom_wait(client.get(), &waited, sizeof waited, 1'000'000), ODOM_STALE);
  EXPECT_EQ(waited.tick, 1U);
}

TEST_F(Succession, TheSuccessorInheritsTheLastPose) {
  EXPECT_FALSE(Writer(settings, test_info()).predecessor().has_value());
  std::uint64_t instance = 0;
  {
    Writer writer(settings, test_info());
    EXPECT_FALSE(writer.predecessor().has_value());  // the predecessor published nothing
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

TEST_F(Succession, DamagedSegmentGivesACompletePoseOrNone) {
  {
    Writer writer(settings, test_info());
    for (std::uint64_t tick = 1; tick <= 100; ++tick) publish_patterned(writer, tick, 10);
  }
  const std::string whole = contents(path);
  const std::size_t newest = 8 * (512 + 100 % 64 * 104);
  int refused = 0;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    std::mt19937 random(seed);
    std::string damaged = whole;
    // In half of the runs the damage lies in the newest slot, in the others anywhere.
    for (unsigned i = 0; i <= random() % 8; ++i) {
      const std::size_t at =
          seed % 2 == 0 ? newest + random() % (8 * 98) : random() % damaged.size();
      damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ 1U << random() % 8);
    }
    std::ofstream(path, std::ios::binary | std::ios::trunc) << damaged;
    try {
      const Claim claim(settings);
      if (claim.predecessor()) {
        ASSERT_TRUE(is_whole(claim.predecessor()->pose, &claim.predecessor()->details)) << seed;
        ASSERT_EQ(claim.predecessor()->pose.time_ns, 10) << seed;
      } else {
        ++refused;
        ASSERT_TRUE(claim.predecessor_is_damaged() || damaged == whole) << seed;
      }
    } catch (const std::runtime_error&) {
      ++refused;  // its first word no longer marks a segment
    }
  }
  EXPECT_GT(refused, 450);
}

TEST_F(Succession, DamagedTickIsNotTakenForAnotherSlot) {
  {
    Writer writer(settings, test_info());
    for (std::uint64_t tick = 1; tick <= 100; ++tick) publish_patterned(writer, tick, 10);
  }
  const std::uint64_t other = 44;  // the slot of this tick is intact
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(8 * (ODOM_SEGMENT_HEADER_WORDS + 100 % 64 * ODOM_SLOT_WORDS + ODOM_SLOT_POSE));
  file.write(reinterpret_cast<const char*>(&other), sizeof other);
  file.close();
  const Claim claim(settings);
  EXPECT_TRUE(claim.predecessor_is_damaged());
  EXPECT_FALSE(claim.predecessor().has_value());
}

TEST_F(Succession, RemovedLockStillExcludesASecondWriter) {
  Writer writer(settings, test_info());
  unlink((path + ".lock").c_str());
  EXPECT_THROW(Claim{settings}, Displaced);
  unlink(path.c_str());
  EXPECT_THROW(Claim{settings}, Displaced);
  EXPECT_FALSE(std::filesystem::exists(path + ".lock")) << "who comes too late touches nothing";
  EXPECT_EQ(writer.maintain(), Upkeep::recreated);
  EXPECT_TRUE(std::filesystem::exists(path + ".lock"));
  unlink((path + ".lock").c_str());
  EXPECT_EQ(writer.maintain(), Upkeep::lock_renewed);
  EXPECT_EQ(writer.maintain(), Upkeep::unchanged);
}

TEST_F(Succession, ClaimAloneChangesNothing) {
  {
    Writer writer(settings, test_info());
    publish_patterned(writer, 7, 70);
  }
  {
    const Claim claim(settings);
    ASSERT_TRUE(claim.predecessor().has_value());
    EXPECT_EQ(claim.predecessor()->pose.tick, 7U);
    EXPECT_THROW(Claim{settings}, Displaced) << "claimed already";
  }
  EXPECT_EQ(Claim(settings).predecessor()->pose.tick, 7U) << "whoever gave up has lost nothing";
  Claim claim(settings);
  const Writer writer(std::move(claim), test_info());
  EXPECT_THROW(Claim{settings}, Displaced) << "the writer holds on to it";
}

TEST_F(Succession, ASegmentOfAnotherUserIsNotInherited) {
  if (geteuid() != 0) {
    std::cout << "not run: 1 (needs root to give a file to another user)\n";
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
