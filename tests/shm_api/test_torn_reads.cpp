// A writer without pauses and several readers, threads and processes: every read that validates
// contains one tick. ODOMD_STRESS_READS=N sets the number of reads.
#include <atomic>
#include <memory>
#include <thread>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"
#include "tests/shm_api/stress.hpp"

namespace odomd::shm::testing::test_torn_reads {
namespace {

class TornReads : public ::testing::Test {
 protected:
  static constexpr std::size_t readers = 4;  // two threads and two processes
  static constexpr ReaderKind kind_of(std::size_t reader) {
    return reader % 2 == 0 ? ReaderKind::in_place : ReaderKind::copying;
  }
  enum class Overlap : std::uint8_t { as_it_comes, wanted };

  // Publishes until all readers together have made this many reads, each has read many ticks, and,
  // if wanted, each in-place reader has seen the writer overwrite its slot.
  void stress(std::uint64_t slots, Overlap overlap) {
    const std::uint64_t reads = wanted("ODOMD_STRESS_READS", 1'000'000);
    const std::string path = directory_.file("pose");
    Writer writer({.name = path, .slots = slots}, test_info());
    publish_patterned(writer, 1, 1);
    std::vector<std::thread> threads;
    std::vector<std::unique_ptr<Process>> processes;
    for (std::size_t i = 0; i < readers; ++i) {
      if (i < readers / 2)
        threads.emplace_back(
            [&, i] { read_on(path, kind_of(i), slots, counts_->readers.at(i), counts_->stop); });
      else
        processes.push_back(std::make_unique<Process>(std::vector<std::string>{
            ODOMD_SHM_STRESS_READER, path, directory_.file("counts"), std::to_string(i),
            std::to_string(static_cast<int>(kind_of(i))), std::to_string(slots)}));
    }

    std::uint64_t tick = 2;
    const std::int64_t deadline = now_ns() + 120'000'000'000;
    while (!enough(reads, overlap) && now_ns() < deadline) {
      for (int i = 0; i < 1000; ++i, ++tick)
        publish_patterned(writer, tick, static_cast<std::int64_t>(tick));
      writer.set_heartbeat(now_ns());
    }
    EXPECT_TRUE(enough(reads, overlap)) << "reader and writer hardly met: nothing was shown";
    counts_->stop = true;
    for (std::thread& thread : threads) thread.join();
    for (const auto& process : processes) EXPECT_EQ(process->wait(), 0);
    std::cout << slots << " slots: " << tick << " ticks written, " << sum(&ReaderCounts::reads)
              << " reads, " << sum(&ReaderCounts::ticks) << " of another tick than the one before, "
              << sum(&ReaderCounts::overtaken) << " attempts in place overtaken, "
              << sum(&ReaderCounts::starved) << " reads starved\n";
  }

  [[nodiscard]] std::uint64_t sum(std::atomic<std::uint64_t> ReaderCounts::*counter) const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < readers; ++i) sum += counts_->readers.at(i).*counter;
    return sum;
  }

  [[nodiscard]] bool enough(std::uint64_t reads, Overlap overlap) const {
    for (std::size_t i = 0; i < readers; ++i) {
      const ReaderCounts& reader = counts_->readers.at(i);
      if (reader.ticks < 100) return false;
      if (overlap == Overlap::wanted && kind_of(i) == ReaderKind::in_place && reader.overtaken == 0)
        return false;
    }
    return sum(&ReaderCounts::reads) >= reads;
  }

  TemporaryDirectory directory_;
  SharedCounts counts_{directory_.file("counts")};
};

// In a ring of four slots the writer overtakes every reader.
TEST_F(TornReads, AReaderThatIsOvertakenKnowsIt) {
  stress(4, Overlap::wanted);
  EXPECT_EQ(sum(&ReaderCounts::torn), 0U);
  EXPECT_EQ(sum(&ReaderCounts::backwards), 0U);
  EXPECT_EQ(sum(&ReaderCounts::unexpected), 0U);
}

TEST_F(TornReads, AUsualRingNeitherTearsNorStarves) {
  stress(1024, Overlap::as_it_comes);
  EXPECT_EQ(sum(&ReaderCounts::torn), 0U);
  EXPECT_EQ(sum(&ReaderCounts::starved), 0U);
  EXPECT_EQ(sum(&ReaderCounts::backwards), 0U);
  EXPECT_EQ(sum(&ReaderCounts::unexpected), 0U);
}

}  // namespace
}  // namespace odomd::shm::testing::test_torn_reads
