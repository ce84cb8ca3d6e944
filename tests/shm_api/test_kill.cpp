// A writer that publishes without pause is repeatedly killed at a random instant and replaced: no
// reader, thread or process, hangs, sees words of two ticks or misses the next writer.
// ODOMD_STRESS_KILLS=N sets the number of kills.
#include <fstream>
#include <memory>
#include <random>
#include <thread>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"
#include "tests/shm_api/stress.hpp"

namespace odomd::shm::testing::test_kill {
namespace {

constexpr std::int64_t fast_ns = 1'000'000;  // the period: poses are stale after 4 ms
constexpr std::int64_t timeout_ns = 20'000'000'000;
constexpr std::size_t slots = 64;  // as in the publisher

// Number of half-written slots of a dead writer.
int half_written(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<std::uint64_t, ODOM_SEGMENT_HEADER_WORDS + slots * ODOM_SLOT_WORDS> words{};
  file.read(reinterpret_cast<char*>(words.data()), sizeof words);
  int count = 0;
  for (std::size_t i = ODOM_SEGMENT_HEADER_WORDS; i < words.size(); i += ODOM_SLOT_WORDS)
    if (words.at(i) % 2 == 1) ++count;
  return count;
}

class Kills : public ::testing::Test {
 protected:
  static constexpr std::size_t readers = 4;  // two threads and two processes

  void start_readers() {
    const auto kind = static_cast<int>(ReaderKind::every_way);
    for (std::size_t i = 0; i < readers; ++i) {
      if (i < readers / 2)
        threads_.emplace_back([this, i] {
          read_on(path_, ReaderKind::every_way, slots, counts_->readers.at(i), counts_->stop);
        });
      else
        processes_.push_back(std::make_unique<Process>(std::vector<std::string>{
            ODOMD_SHM_STRESS_READER, path_, directory_.file("counts"), std::to_string(i),
            std::to_string(kind), std::to_string(slots)}));
    }
  }

  void stop_readers() {
    counts_->stop = true;
    for (std::thread& thread : threads_) thread.join();
    for (const auto& process : processes_) EXPECT_EQ(process->wait(), 0);
  }

  void pause(std::uint64_t up_to_us) {
    std::this_thread::sleep_for(std::chrono::microseconds(random_() % up_to_us));
  }

  template <typename Condition>
  bool await(const Condition& condition) {
    const std::int64_t deadline = now_ns() + timeout_ns;
    while (!condition()) {
      if (now_ns() > deadline) return false;
      pause(100);
    }
    return true;
  }

  // Whether each reader completes two more turns.
  bool all_go_on() {
    std::array<std::uint64_t, readers> turns{};
    for (std::size_t i = 0; i < readers; ++i) turns.at(i) = counts_->readers.at(i).turns;
    return await([&] {
      for (std::size_t i = 0; i < readers; ++i)
        if (counts_->readers.at(i).turns < turns.at(i) + 2) return false;
      return true;
    });
  }

  TemporaryDirectory directory_;
  std::string path_ = directory_.file("pose");
  SharedCounts counts_{directory_.file("counts")};
  std::vector<std::thread> threads_;
  std::vector<std::unique_ptr<Process>> processes_;
  std::mt19937_64 random_{7};
};

TEST_F(Kills, ReadersSurviveTheWritersDeathAtAnyInstant) {
  const std::uint64_t kills = wanted("ODOMD_STRESS_KILLS", 100);
  { Writer first({.name = path_, .slots = slots}, test_info(fast_ns)); }
  start_readers();
  const ClientPointer client = open_client(path_);
  std::uint64_t followed = 0;
  std::uint64_t in_a_slot = 0;
  for (std::uint64_t i = 0; i < kills; ++i) {
    {
      const Process publisher({ODOMD_SHM_PUBLISHER, path_, std::to_string(fast_ns)});
      if (i % 4 != 0) {
        // Killed while it publishes: the old client still gets its poses.
        odom_pose pose{};
        ASSERT_TRUE(await([&] { return odom_latest(client.get(), &pose, sizeof pose) == ODOM_OK; }))
            << "kill " << i;
        EXPECT_TRUE(is_whole(pose));
        ++followed;
        pause(2000);
      } else {
        pause(4000);  // killed while it starts
      }
    }
    ASSERT_TRUE(all_go_on()) << "kill " << i;
    if (half_written(path_) != 0) ++in_a_slot;
    if (i % 8 == 7) {
      const Writer heir({.name = path_, .slots = slots}, test_info(fast_ns));
      if (heir.predecessor()) {
        EXPECT_TRUE(is_whole(heir.predecessor()->pose, &heir.predecessor()->details));
      }
    }
  }
  stop_readers();
  std::uint64_t reads = 0;
  for (std::size_t i = 0; i < readers; ++i) {
    const ReaderCounts& reader = counts_->readers.at(i);
    EXPECT_EQ(reader.torn, 0U);
    EXPECT_EQ(reader.unexpected, 0U);
    EXPECT_GT(reader.instances, kills / 10);
    reads += reader.reads;
  }
  std::cout << kills << " kills, " << in_a_slot << " of them while a slot was written; " << followed
            << " successors followed; " << reads << " reads\n";
}

}  // namespace
}  // namespace odomd::shm::testing::test_kill
