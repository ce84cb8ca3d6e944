// A writer that never pauses against several readers: what validates is one tick, always.
#include <gtest/gtest.h>
#include <array>
#include <atomic>
#include <latch>
#include <thread>
#include <vector>

#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing {
namespace {

struct Counts {
  std::uint64_t reads = 0;
  std::uint64_t overtaken = 0;  // the writer was seen at work in the slot
  std::uint64_t torn = 0;
  std::uint64_t backwards = 0;
  std::uint64_t starved = 0;
};

// In place, so that every single attempt is seen. Half-way through it waits until the slot is the
// one that is written next, so that the other half is read while the writer is at work in it.
void read_in_place(odom_client* client, std::uint64_t slots, Counts& counts) {
  odom_view view{};
  if (odom_begin(client, &view) > ODOM_STALE) return;
  std::array<std::uint64_t, ODOM_POSE_WORDS + ODOM_DETAILS_WORDS> words{};
  std::size_t i = 0;
  for (; i < words.size() / 2; ++i) words[i] = odom_view_word(&view, i + 1);
  odom_view newest = view;
  for (int patience = 0; patience < 1000; ++patience) {
    if (newest.sequence >= view.sequence + 2 * (slots - 1)) break;
    if (odom_begin(client, &newest) > ODOM_STALE) return;
  }
  for (; i < words.size(); ++i) words[i] = odom_view_word(&view, i + 1);
  if (odom_validate(&view) == 0) {
    ++counts.overtaken;
    return;
  }
  ++counts.reads;
  for (i = 2; i < words.size(); ++i)
    if (words[i] != pattern(words[0], i)) {
      ++counts.torn;
      return;
    }
}

void read_copy(odom_client* client, odom_pose& pose, Counts& counts) {
  const std::uint64_t before = pose.tick;
  const odom_status status = odom_latest(client, &pose, sizeof pose);
  if (status == ODOM_BUSY) {
    ++counts.starved;
    if (pose.mode != ODOM_FAULT || pose.x != 0.0) ++counts.torn;  // a mixture was handed out
    pose.tick = before;
  }
  if (status > ODOM_STALE) return;
  ++counts.reads;
  if (!is_whole(pose)) ++counts.torn;
  if (pose.tick < before) ++counts.backwards;
}

// Half a second, and on until the writer has been seen at work if that is wanted.
std::vector<Counts> stress(std::uint64_t slots, bool until_overtaken) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("pose");
  Writer writer({.name = path, .slots = slots}, test_info());
  publish_patterned(writer, 1, 1);

  // Half of the readers read in place, half copy.
  const std::size_t reader_count = 4;
  std::vector<Counts> counts(reader_count);
  std::latch gate(static_cast<std::ptrdiff_t>(reader_count) + 1);
  std::atomic<bool> stop{false};
  std::atomic<bool> overtaken{false};
  std::vector<std::thread> readers;
  readers.reserve(reader_count);
  for (std::size_t reader = 0; reader < reader_count; ++reader)
    readers.emplace_back([&, reader] {
      const ClientPointer client = open_client(path);
      Counts& count = counts[reader];
      odom_pose pose{};
      gate.arrive_and_wait();
      while (!stop.load(std::memory_order_relaxed)) {
        if (reader % 2 == 0)
          read_in_place(client.get(), slots, count);
        else
          read_copy(client.get(), pose, count);
        if (count.overtaken != 0) overtaken.store(true, std::memory_order_relaxed);
      }
    });

  gate.arrive_and_wait();
  const std::int64_t start = now_ns();
  std::uint64_t tick = 2;
  const auto wanted = [&] {
    const std::int64_t ran = now_ns() - start;
    if (ran < 500'000'000) return true;
    return until_overtaken && !overtaken.load(std::memory_order_relaxed) && ran < 30'000'000'000;
  };
  while (wanted()) {
    for (int i = 0; i < 1000; ++i, ++tick)
      publish_patterned(writer, tick, static_cast<std::int64_t>(tick));
    writer.set_heartbeat(now_ns());
  }
  stop = true;
  for (std::thread& reader : readers) reader.join();
  return counts;
}

TEST(TornReads, AReaderThatIsOvertakenKnowsIt) {
  Counts all;
  for (const Counts& count : stress(4, true)) {
    EXPECT_EQ(count.torn, 0U);
    EXPECT_EQ(count.backwards, 0U);
    all.reads += count.reads;
    all.overtaken += count.overtaken;
  }
  EXPECT_GT(all.reads, 0U);
  EXPECT_GT(all.overtaken, 0U) << "reader and writer never met: nothing was shown";
}

TEST(TornReads, AUsualRingNeitherTearsNorStarves) {
  for (const Counts& count : stress(1024, false)) {
    EXPECT_GT(count.reads, 0U);
    EXPECT_EQ(count.torn, 0U);
    EXPECT_EQ(count.backwards, 0U);
    EXPECT_EQ(count.starved, 0U);
  }
}

}  // namespace
}  // namespace odomd::shm::testing
