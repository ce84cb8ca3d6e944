// Clients read what the writer publishes: copied, in place, with details, and from the header.
#include <unistd.h>
#include <cstring>
#include <fstream>

#include "shm_api/layout/slot.h"
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

TEST_F(RoundTrip, LatestIsTheNewestPose) {
  odom_view view{};
  EXPECT_EQ(latest(client).first, ODOM_NO_POSE);
  EXPECT_EQ(odom_begin(client.get(), &view), ODOM_NO_POSE);
  for (std::uint64_t tick : {0U, 1U, 2U, 3U, 7U, 20U, 21U}) {
    publish_patterned(writer, tick, now_ns());
    odom_pose pose{};
    pose.tick = 77;
    ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
    EXPECT_EQ(pose.tick, tick);
    EXPECT_TRUE(is_whole(pose));
  }
}

TEST_F(RoundTrip, NonIncreasingTickIsNotPublished) {
  const Record second = patterned(2, 20);
  const Record first = patterned(1, 10);
  EXPECT_TRUE(writer.publish(second.pose, second.details));
  EXPECT_FALSE(writer.publish(first.pose, first.details));
  EXPECT_FALSE(writer.publish(second.pose, second.details));
  EXPECT_EQ(latest(client), Latest(ODOM_OK, 2));
  EXPECT_EQ(writer.beat().ticks, 1U);
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

TEST_F(RoundTrip, WriterThatStopsWithinASlotBlocksNoReader) {
  publish_patterned(writer, 1, 1);
  // As seen by a reader that has preempted the writer on its CPU: tick 2 is half written.
  const std::array<std::uint64_t, 3> half{odomi_sequence(2) - 1, 2, pattern(2, 1)};
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(8 * (ODOM_SEGMENT_HEADER_WORDS + 2 * ODOM_SLOT_WORDS));
  file.write(reinterpret_cast<const char*>(half.data()), sizeof half);
  file.close();
  odom_view view{};
  ASSERT_EQ(odom_begin(client.get(), &view), ODOM_OK);
  EXPECT_EQ(odom_view_word(&view, ODOM_WORD_TICK), 1U);
  EXPECT_TRUE(odom_validate(&view)) << "at the first attempt";
  odom_pose pose{};
  ASSERT_EQ(odom_latest(client.get(), &pose, sizeof pose), ODOM_OK);
  EXPECT_TRUE(pose.tick == 1 && is_whole(pose));
  EXPECT_EQ(odom_wait(client.get(), &pose, sizeof pose, 1'000'000), ODOM_TIMEOUT);
}

TEST_F(RoundTrip, SmallerStructOfAnOlderProgramIsFilledExactly) {
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

TEST_F(RoundTrip, LargerStructOfANewerProgramEndsInZeros) {
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

TEST_F(RoundTrip, InfoIsTheWriters) {
  writer.set_first_tick(123);
  writer.set_realtime_offset(456);
  writer.set_log_offset(789);
  odom_info expected = test_info(1'000'000'000);
  expected.abi_major = ODOM_ABI_MAJOR;
  expected.abi_minor = ODOM_ABI_MINOR;
  expected.instance_id = writer.info().instance_id;
  expected.writer_pid = static_cast<decltype(expected.writer_pid)>(getpid());
  expected.writer_start_ns = writer.info().writer_start_ns;
  expected.first_tick_ns = 123;
  expected.realtime_offset_ns = 456;
  expected.log_offset_ns = 789;
  expected.slots = 8;
  odom_info info{};
  ASSERT_EQ(odom_get_info(client.get(), &info, sizeof info), ODOM_OK);
  EXPECT_NE(info.instance_id, 0U);
  EXPECT_TRUE(is_same(info, expected));
}

TEST_F(RoundTrip, TimesConvertToOtherClocks) {
  const auto convert = [&](int clock, std::int64_t time) {
    std::int64_t converted = 0;
    const odom_status status =
        odom_to_clock(client.get(), static_cast<odom_clock>(clock), time, &converted);
    return std::pair(status, converted);
  };
  using Converted = std::pair<odom_status, std::int64_t>;
  EXPECT_EQ(convert(ODOM_CLOCK_LOG, 5).first, ODOM_INVALID);
  writer.set_realtime_offset(1000);
  writer.set_log_offset(-7);
  EXPECT_EQ(convert(ODOM_CLOCK_MONOTONIC, 5), Converted(ODOM_OK, 5));
  EXPECT_EQ(convert(ODOM_CLOCK_REALTIME, 5), Converted(ODOM_OK, 1005));
  EXPECT_EQ(convert(ODOM_CLOCK_LOG, 5), Converted(ODOM_OK, -2));
  EXPECT_EQ(convert(ODOM_CLOCK_REALTIME, INT64_MAX).first, ODOM_INVALID);
  EXPECT_EQ(convert(3, 5).first, ODOM_INVALID);
}

TEST_F(RoundTrip, BeatCountsAndHistograms) {
  for (const std::int64_t ns : {0, 999, 1000, 1190, -5}) writer.count_wakeup(ns);
  for (const std::int64_t ns : {2000L, 46'340'950L, 46'340'951L, INT64_MAX})
    writer.count_execution(ns);
  writer.count_missed(3);
  writer.count_overrun(70, 80);
  writer.count_carried_over();
  writer.set_heartbeat(1234);
  odom_beat expected{};
  expected.wakeup[0] = 3;  // below 1 us; -5: the clock went back slightly
  expected.wakeup[1] = 1;
  expected.wakeup[2] = 1;     // [2^(1/4), 2^(2/4)) us
  expected.execution[5] = 1;  // [2^(4/4), 2^(5/4)) us
  expected.execution[ODOM_HISTOGRAM_BUCKETS - 2] = 1;
  expected.execution[ODOM_HISTOGRAM_BUCKETS - 1] = 2;  // from 2^(62/4) us
  expected.max_wakeup_ns = 1190;
  expected.max_execution_ns = INT64_MAX;
  expected.missed = 3;
  expected.overruns = 1;
  expected.last_overrun_ns = 70;
  expected.last_overrun_execution_ns = 80;
  expected.carried_over = 1;
  expected.heartbeat_ns = 1234;
  odom_beat beat{};
  EXPECT_EQ(odom_get_beat(client.get(), &beat, sizeof beat), ODOM_STALE);
  EXPECT_TRUE(is_same(beat, expected));
  EXPECT_TRUE(is_same(writer.beat(), expected));
}

}  // namespace
}  // namespace odomd::shm::testing::test_round_trip
