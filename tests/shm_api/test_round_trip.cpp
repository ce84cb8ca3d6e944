// Clients read what the writer publishes: copied, in place, with details, and from the header.
#include <cstring>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_round_trip {
namespace {

class RoundTrip : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  Writer writer{{.name = path, .slots = 8}, test_info(1'000'000'000)};  // fresh for 4 s
  ClientPointer client = open_client(path);
};

TEST_F(RoundTrip, NothingPublishedIsNoPose) {
  odom_pose pose{};
  EXPECT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_NO_POSE);
  odom_view view{};
  EXPECT_EQ(odom_begin(client.get(), &view), ODOM_NO_POSE);
}

TEST_F(RoundTrip, LatestIsTheNewestPose) {
  for (std::uint64_t tick : {1U, 2U, 3U, 7U, 20U, 21U}) {
    publish_patterned(writer, tick, now_ns());
    odom_pose pose{};
    ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
    EXPECT_EQ(pose.tick, tick);
    EXPECT_TRUE(is_whole(pose));
  }
}

TEST_F(RoundTrip, TickZeroIsATick) {
  publish_patterned(writer, 0, 5);
  odom_pose pose{};
  pose.tick = 77;
  ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
  EXPECT_EQ(pose.tick, 0U);
}

TEST_F(RoundTrip, DetailsBelongToTheSameTick) {
  publish_patterned(writer, 1, now_ns());
  publish_patterned(writer, 2, now_ns());
  odom_pose pose{};
  odom_details details{};
  ASSERT_EQ(odom_latest_details(client.get(), &pose, sizeof pose, &details, sizeof details),
            ODOM_OK);
  EXPECT_EQ(pose.tick, 2U);
  EXPECT_TRUE(is_whole(pose, &details));
}

TEST_F(RoundTrip, ATickThatDoesNotRiseIsNotPublished) {
  const Record second = patterned(2, 20);
  const Record first = patterned(1, 10);
  EXPECT_TRUE(writer.publish(second.pose, second.details));
  EXPECT_FALSE(writer.publish(first.pose, first.details));
  EXPECT_FALSE(writer.publish(second.pose, second.details));
  odom_pose pose{};
  ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
  EXPECT_EQ(pose.tick, 2U);
  EXPECT_EQ(writer.beat().ticks, 1U);
}

TEST_F(RoundTrip, InPlaceWordsAreThePose) {
  Record record = patterned(5, 1234);
  record.pose.mode = ODOM_STANDSTILL;
  record.pose.conditions = ODOM_COND_BUS_DOWN;
  record.pose.reset_count = 3;
  record.pose.health = 0x81;
  record.pose.yaw = -2.5;
  record.details.gyro_bias = 0.125;
  writer.publish(record.pose, record.details);

  odom_view view{};
  ASSERT_EQ(odom_begin(client.get(), &view), ODOM_OK);
  EXPECT_EQ(odom_view_word(&view, ODOM_WORD_TICK), 5U);
  EXPECT_EQ(odom_view_word(&view, ODOM_WORD_TIME), 1234U);
  EXPECT_EQ(odom_view_double(&view, ODOM_WORD_YAW), -2.5);
  EXPECT_EQ(odom_view_word(&view, ODOM_WORD_MODE),
            ODOM_STANDSTILL | (std::uint64_t{ODOM_COND_BUS_DOWN} << 32U));
  EXPECT_EQ(odom_view_word(&view, ODOM_WORD_RESETS), 3U | (std::uint64_t{0x81} << 32U));
  EXPECT_EQ(odom_view_double(&view, ODOM_WORD_DETAILS + 15), 0.125);
  EXPECT_TRUE(odom_validate(&view));
}

TEST_F(RoundTrip, ValidateDetectsThatTheSlotWasOverwritten) {
  publish_patterned(writer, 1, 1);
  odom_view view{};
  ASSERT_EQ(odom_begin(client.get(), &view), ODOM_OK);
  // A published slot stays unchanged for one round of the ring: eight ticks.
  for (std::uint64_t tick = 2; tick <= 8; ++tick) {
    publish_patterned(writer, tick, static_cast<std::int64_t>(tick));
    EXPECT_TRUE(odom_validate(&view)) << tick;
  }
  publish_patterned(writer, 9, 9);
  EXPECT_FALSE(odom_validate(&view));
}

TEST_F(RoundTrip, AnOlderProgramsSmallerStructIsFilledAndNothingBeyondIt) {
  publish_patterned(writer, 1, 1);
  odom_pose pose{};
  std::memset(&pose, 0x5A, sizeof pose);
  ASSERT_EQ(odom_latest(client.get(), &pose, offsetof(odom_pose, odom_x)), ODOM_OK);
  EXPECT_EQ(pose.tick, 1U);
  std::uint64_t beyond = 0;
  std::memcpy(&beyond, &pose.odom_x, sizeof beyond);
  EXPECT_EQ(beyond, 0x5A5A5A5A5A5A5A5AU);

  odom_details details{};  // as in a program built with ABI 1.0
  std::memset(&details, 0x5A, sizeof details);
  ASSERT_EQ(odom_latest_details(client.get(), &pose, sizeof pose, &details,
                                offsetof(odom_details, gyro_latency)),
            ODOM_OK);
  EXPECT_EQ(details.execution_ns, patterned(1, 1).details.execution_ns);
  std::memcpy(&beyond, &details.gyro_latency, sizeof beyond);
  EXPECT_EQ(beyond, 0x5A5A5A5A5A5A5A5AU);
}

TEST_F(RoundTrip, AYoungerProgramsLargerStructEndsInZeros) {
  publish_patterned(writer, 1, 1);
  struct {
    odom_pose pose;
    odom_details details;
    std::uint64_t later[2];
  } larger{};
  larger.later[0] = larger.later[1] = 1;
  ASSERT_EQ(odom_latest_details(client.get(), &larger.pose, sizeof larger.pose, &larger.details,
                                sizeof larger.details + sizeof larger.later),
            ODOM_OK);
  EXPECT_TRUE(is_whole(larger.pose, &larger.details));
  EXPECT_EQ(larger.later[0], 0U);
  EXPECT_EQ(larger.later[1], 0U);
}

TEST_F(RoundTrip, UnusableArgumentsAreInvalid) {
  odom_pose pose{};
  EXPECT_EQ(odom_latest(nullptr, &pose, sizeof pose), ODOM_INVALID);
  EXPECT_EQ(odom_latest(client.get(), nullptr, sizeof pose), ODOM_INVALID);
  EXPECT_EQ(odom_latest(client.get(), &pose, 0), ODOM_INVALID);
  EXPECT_EQ(odom_latest(client.get(), &pose, sizeof pose - 1), ODOM_INVALID);
  EXPECT_EQ(odom_wait(client.get(), &pose, 8, 0), ODOM_INVALID);
  EXPECT_EQ(odom_open("/odomd", nullptr), ODOM_INVALID);
  for (const char* name : {"no-slash", "/tmp/", ""}) {
    odom_client* opened = client.get();
    EXPECT_EQ(odom_open(name, &opened), ODOM_INVALID) << name;
    EXPECT_EQ(opened, nullptr) << name;
  }
  odom_close(nullptr);
}

TEST_F(RoundTrip, InfoIsWhatTheWriterSaid) {
  writer.set_first_tick(123);
  writer.set_realtime_offset(456);
  writer.set_log_offset(789);
  odom_info info{};
  ASSERT_EQ(odom_get_info(client.get(), &info, sizeof info), ODOM_OK);
  EXPECT_EQ(info.abi_major, 1U);
  EXPECT_EQ(info.instance_id, writer.info().instance_id);
  EXPECT_NE(info.instance_id, 0U);
  EXPECT_EQ(info.writer_pid, getpid());
  EXPECT_EQ(info.period_ns, 1'000'000'000);
  EXPECT_EQ(info.first_tick_ns, 123);
  EXPECT_EQ(info.realtime_offset_ns, 456);
  EXPECT_EQ(info.log_offset_ns, 789);
  EXPECT_EQ(info.slots, 8U);
  EXPECT_EQ(info.mass, 2.985);
  EXPECT_STREQ(info.model, "paper");
  EXPECT_STREQ(info.version, "0.1.0");
}

TEST_F(RoundTrip, TimesConvertToOtherClocks) {
  std::int64_t converted = 0;
  EXPECT_EQ(odom_to_clock(client.get(), ODOM_CLOCK_LOG, 5, &converted), ODOM_INVALID);
  writer.set_realtime_offset(1000);
  writer.set_log_offset(-7);
  ASSERT_EQ(odom_to_clock(client.get(), ODOM_CLOCK_MONOTONIC, 5, &converted), ODOM_OK);
  EXPECT_EQ(converted, 5);
  ASSERT_EQ(odom_to_clock(client.get(), ODOM_CLOCK_REALTIME, 5, &converted), ODOM_OK);
  EXPECT_EQ(converted, 1005);
  ASSERT_EQ(odom_to_clock(client.get(), ODOM_CLOCK_LOG, 5, &converted), ODOM_OK);
  EXPECT_EQ(converted, -2);
  EXPECT_EQ(odom_to_clock(client.get(), ODOM_CLOCK_REALTIME, INT64_MAX, &converted), ODOM_INVALID);
  EXPECT_EQ(odom_to_clock(client.get(), static_cast<odom_clock>(3), 5, &converted), ODOM_INVALID);
}

TEST_F(RoundTrip, BeatCountsAndHistograms) {
  writer.count_wakeup(0);
  writer.count_wakeup(999);
  writer.count_wakeup(1000);
  writer.count_wakeup(1190);  // [2^(1/4), 2^(2/4)) us
  writer.count_wakeup(-5);    // the clock went back slightly: counts as zero
  writer.count_execution(2000);
  writer.count_execution(46'340'950);
  writer.count_execution(46'340'951);  // beyond 2^(62/4) us: the last bucket
  writer.count_execution(INT64_MAX);
  writer.count_missed(3);
  writer.count_overrun(70, 80);
  writer.count_carried_over();
  writer.set_heartbeat(now_ns());
  odom_beat beat{};
  ASSERT_EQ(odom_get_beat(client.get(), &beat, sizeof beat), ODOM_OK);
  EXPECT_EQ(beat.wakeup[0], 3U);
  EXPECT_EQ(beat.wakeup[1], 1U);
  EXPECT_EQ(beat.wakeup[2], 1U);
  EXPECT_EQ(beat.max_wakeup_ns, 1190);
  EXPECT_EQ(beat.execution[5], 1U);  // [2^(4/4), 2^(5/4)) us
  EXPECT_EQ(beat.execution[ODOM_HISTOGRAM_BUCKETS - 2], 1U);
  EXPECT_EQ(beat.execution[ODOM_HISTOGRAM_BUCKETS - 1], 2U);
  EXPECT_EQ(beat.max_execution_ns, INT64_MAX);
  EXPECT_EQ(beat.missed, 3U);
  EXPECT_EQ(beat.overruns, 1U);
  EXPECT_EQ(beat.last_overrun_ns, 70);
  EXPECT_EQ(beat.last_overrun_execution_ns, 80);
  EXPECT_EQ(beat.carried_over, 1U);
  const odom_beat own = writer.beat();
  EXPECT_EQ(std::memcmp(&beat, &own, sizeof beat), 0);
}

}  // namespace
}  // namespace odomd::shm::testing::test_round_trip
