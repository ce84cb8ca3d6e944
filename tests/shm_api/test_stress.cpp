// A writer without pauses and several readers, threads and processes. Every read that validates
// contains one tick (TornReads; ODOMD_STRESS_READS=N sets the number of reads). The writer is
// repeatedly killed at a random instant and replaced (Kills; ODOMD_STRESS_KILLS=N): no reader
// hangs, sees words of two ticks or misses the next writer.
#include <sys/prctl.h>
#include <unistd.h>

#include <random>
#include <thread>

#include "tests/shm_api/segment_fixture.hpp"
#include "tests/shm_api/stress.hpp"

namespace odomd::shm::testing::test_stress {
namespace {

class Stress : public ::testing::Test {
 public:
  ~Stress() override { counts_->stop = true; }  // after a failed assertion, too

 protected:
  static constexpr std::size_t readers = SharedCounts::capacity;  // two threads and two processes
  using Kinds = std::array<ReaderKind, readers>;

  void start_readers(const Kinds& kinds, std::uint64_t slots) {
    const auto read = [=, this](std::size_t i) {
      read_on(path_, kinds.at(i), slots, counts_->readers.at(i), counts_->stop);
    };
    for (std::size_t i = 0; i < readers / 2; ++i) {  // before there are threads
      processes_.push_back(fork());
      if (processes_.back() != 0) continue;
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      _exit(message_of([&] { read(i); }).empty() ? 0 : 1);
    }
    for (std::size_t i = readers / 2; i < readers; ++i) threads_.emplace_back(read, i);
  }

  void stop_readers() {
    counts_->stop = true;
    for (std::jthread& thread : threads_) thread.join();
    for (const pid_t process : processes_) {
      int status = -1;
      EXPECT_EQ(waitpid(process, &status, 0), process);
      EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    }
    EXPECT_EQ(sum(&ReaderCounts::torn), 0U);
    EXPECT_EQ(sum(&ReaderCounts::backwards), 0U);
    EXPECT_EQ(sum(&ReaderCounts::unexpected), 0U);
  }

  [[nodiscard]] std::uint64_t sum(std::atomic<std::uint64_t> ReaderCounts::*counter) const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < readers; ++i) sum += counts_->readers.at(i).*counter;
    return sum;
  }

  TemporaryDirectory directory_;
  std::string path_ = directory_.file("pose");
  SharedCounts counts_;
  std::vector<std::jthread> threads_;
  std::vector<pid_t> processes_;
};

// Reads that are torn -----------------------------------------------------------------------------

class TornReads : public Stress {
 protected:
  static constexpr Kinds kinds{ReaderKind::in_place, ReaderKind::copying, ReaderKind::in_place,
                               ReaderKind::copying};
  enum class Overlap : std::uint8_t { as_it_comes, wanted };

  // Publishes until all readers together have made this many reads, each has read many ticks, and,
  // if wanted, each in-place reader has seen the writer overwrite its slot.
  void stress(std::uint64_t slots, Overlap overlap) {
    const std::uint64_t reads = wanted("ODOMD_STRESS_READS", 1'000'000);
    Writer writer({.name = path_, .slots = slots}, test_info());
    publish_patterned(writer, 1, 1);
    start_readers(kinds, slots);
    std::uint64_t tick = 2;
    const std::int64_t deadline = now_ns() + 120'000'000'000;
    while (!enough(reads, overlap) && now_ns() < deadline) {
      for (int i = 0; i < 1000; ++i, ++tick)
        publish_patterned(writer, tick, static_cast<std::int64_t>(tick));
      writer.set_heartbeat(now_ns());
    }
    EXPECT_TRUE(enough(reads, overlap)) << "reader and writer hardly met: nothing was shown";
    stop_readers();
    std::cout << slots << " slots: " << tick << " ticks written, " << sum(&ReaderCounts::reads)
              << " reads, " << sum(&ReaderCounts::ticks) << " of another tick than the one before, "
              << sum(&ReaderCounts::overtaken) << " attempts in place overtaken, "
              << sum(&ReaderCounts::starved) << " reads starved\n";
  }

  [[nodiscard]] bool enough(std::uint64_t reads, Overlap overlap) const {
    for (std::size_t i = 0; i < readers; ++i) {
      const ReaderCounts& reader = counts_->readers.at(i);
      const bool in_place = kinds.at(i) == ReaderKind::in_place;
      if (reader.ticks < 100) return false;
      if (overlap == Overlap::wanted && in_place && reader.overtaken == 0) return false;
    }
    return sum(&ReaderCounts::reads) >= reads;
  }
};

// In a ring of four slots the writer overtakes every reader.
TEST_F(TornReads, OvertakenReaderDetectsIt) {
  stress(4, Overlap::wanted);
}

TEST_F(TornReads, UsualRingNeitherTearsNorStarves) {
  stress(1024, Overlap::as_it_comes);
  EXPECT_EQ(sum(&ReaderCounts::starved), 0U);
}

// Writers that are killed -------------------------------------------------------------------------

class Kills : public Stress {
 protected:
  static constexpr std::int64_t fast_ns = 1'000'000;  // the period: poses are stale after 4 ms
  static constexpr std::size_t slots = 64;            // as in the publisher

  // Number of half-written slots of a dead writer.
  [[nodiscard]] int half_written() const {
    const std::string bytes = contents(path_);
    std::vector<std::uint64_t> words(ODOM_SEGMENT_HEADER_WORDS + slots * ODOM_SLOT_WORDS);
    std::memcpy(words.data(), bytes.data(), std::min(bytes.size(), 8 * words.size()));
    int count = 0;
    for (std::size_t i = ODOM_SEGMENT_HEADER_WORDS; i < words.size(); i += ODOM_SLOT_WORDS)
      if (words.at(i) % 2 == 1) ++count;
    return count;
  }

  void pause(std::uint64_t up_to_us) {
    std::this_thread::sleep_for(std::chrono::microseconds(random_() % up_to_us));
  }

  // Whether each reader completes two more turns.
  bool all_go_on() {
    std::array<std::uint64_t, readers> turns{};
    for (std::size_t i = 0; i < readers; ++i) turns.at(i) = counts_->readers.at(i).turns;
    const auto all_have = [&] {
      for (std::size_t i = 0; i < readers; ++i)
        if (counts_->readers.at(i).turns < turns.at(i) + 2) return false;
      return true;
    };
    return eventually(all_have, std::chrono::milliseconds{1});
  }

  std::mt19937_64 random_{7};
};

TEST_F(Kills, ReadersSurviveTheWritersDeathAtAnyInstant) {
  const std::uint64_t kills = wanted("ODOMD_STRESS_KILLS", 100);
  { Writer first({.name = path_, .slots = slots}, test_info(fast_ns)); }
  constexpr ReaderKind kind = ReaderKind::every_way;
  start_readers({kind, kind, kind, kind}, slots);
  const ClientPointer client = open_client(path_);
  std::uint64_t followed = 0;
  std::uint64_t in_a_slot = 0;
  for (std::uint64_t i = 0; i < kills; ++i) {
    {
      const Process publisher({ODOMD_SHM_PUBLISHER, path_, std::to_string(fast_ns)}, "/dev/null",
                              "/dev/null");
      if (i % 4 != 0) {
        // Killed while publishing: the old client gets this writer's poses, not only old ones.
        odom_pose pose{};
        odom_info info{};
        const auto follows = [&] {
          return odom_latest(client.get(), &pose, sizeof pose) == ODOM_OK &&
                 odom_get_info(client.get(), &info, sizeof info) == ODOM_OK &&
                 info.writer_pid == publisher.pid();
        };
        ASSERT_TRUE(eventually(follows, std::chrono::milliseconds{1})) << "kill " << i;
        EXPECT_TRUE(is_whole(pose));
        ++followed;
        pause(2000);
      } else {
        pause(4000);  // killed while it starts
      }
    }
    ASSERT_TRUE(all_go_on()) << "kill " << i;
    if (half_written() != 0) ++in_a_slot;
    if (i % 8 == 7) {
      const Writer heir({.name = path_, .slots = slots}, test_info(fast_ns));
      ASSERT_TRUE(heir.predecessor()) << "kill " << i;
      EXPECT_TRUE(is_whole(heir.predecessor()->pose, &heir.predecessor()->details));
    }
  }
  stop_readers();
  for (std::size_t i = 0; i < readers; ++i) EXPECT_GT(counts_->readers.at(i).instances, kills / 10);
  std::cout << kills << " kills, " << in_a_slot << " of them while a slot was written; " << followed
            << " successors followed; " << sum(&ReaderCounts::reads) << " reads\n";
}

}  // namespace
}  // namespace odomd::shm::testing::test_stress
