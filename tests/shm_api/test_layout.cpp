// The segment as a whole, against an image that ABI 1.0 wrote: it is kept, still written, still
// read. The numbers by which programs look into it are pinned in test_abi.cpp.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_layout {
namespace {

std::vector<std::uint64_t> words_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), {});
  std::vector<std::uint64_t> words(bytes.size() / 8);
  std::memcpy(words.data(), bytes.data(), 8 * words.size());
  return words;
}

// The same on every machine, but for who wrote it and when.
void write_reference(const std::string& path) {
  odom_info info = test_info();
  info.first_tick_ns = 1000;
  info.realtime_offset_ns = 2000;
  info.log_offset_ns = 3000;
  info.front_axle = 0.175;
  info.rear_axle = 0.085;
  info.yaw_inertia = 0.0283384;
  info.cornering_stiffness_front = 20.0;
  info.cornering_stiffness_rear = 60.0;
  Writer writer({.name = path, .slots = 4}, info);
  for (std::uint64_t tick : {1U, 2U, 3U, 6U})
    publish_patterned(writer, tick, static_cast<std::int64_t>(tick) * period_ns);
  writer.count_wakeup(17'000);
  writer.count_execution(9'000);
  writer.count_missed(2);
  writer.count_overrun(40, 50);
  writer.count_carried_over();
  writer.wake_clients();
}

constexpr std::array<std::size_t, 4> volatile_words{9, 10, 11, 71};  // instance, pid, start, beat

TEST(Layout, TheSegmentLiesWhereReadersLook) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("pose");
  write_reference(path);
  const std::vector<std::uint64_t> words = words_of(path);
  ASSERT_EQ(words.size(), 512U + 4U * 96U);
  EXPECT_EQ(std::memcmp(words.data(), "ODOMSEG1", 8), 0);
  EXPECT_EQ(words[1], 4096U);             // bytes of the header
  EXPECT_EQ(words[2], 768U);              // bytes from slot to slot
  EXPECT_EQ(words[3], 8 * words.size());  // bytes of the whole
  EXPECT_EQ(words[4], 28U);               // words of a pose
  EXPECT_EQ(words[5], 61U);               // words of its details
  EXPECT_EQ(words[6], 24U);
  EXPECT_EQ(words[7], 137U);
  EXPECT_EQ(words[8], 1U);    // ABI 1.0: major low, minor high
  EXPECT_EQ(words[64], 14U);  // head: tick 6
  EXPECT_EQ(words[65], 1U);   // one wake-up
  EXPECT_EQ(words[67], 4U);   // ticks
  EXPECT_EQ(words[68], 2U);   // missed
  for (const std::uint64_t tick : {1U, 3U, 6U}) {
    const std::size_t slot = 512 + (tick % 4) * 96;
    EXPECT_EQ(words[slot], 2 * tick + 2);
    EXPECT_EQ(words[slot + 1], tick);
    EXPECT_EQ(words[slot + 1 + 3], pattern(tick, 3));
    EXPECT_EQ(words[slot + 29], pattern(tick, 28));
  }
  EXPECT_EQ(words[512], 0U);  // tick 4 was missed
}

TEST(Layout, TheWriterStillWritesTheImageOfAbi1) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("pose");
  write_reference(path);
  std::vector<std::uint64_t> written = words_of(path);
  std::vector<std::uint64_t> kept = words_of(ODOMD_TEST_DATA "/segment_abi_1_0.bin");
  ASSERT_EQ(written.size(), kept.size());
  for (const std::size_t i : volatile_words) written[i] = kept[i] = 0;
  // Of pose and details, in what is room for those who do not know it: younger than the image.
  for (const std::uint64_t tick : {1U, 3U, 6U}) {
    std::uint64_t& checksum = written[512 + (tick % 4) * 96 + 95];
    EXPECT_NE(checksum, 0U);
    checksum = 0;
  }
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(written[i], kept[i]) << "word " << i;
}

TEST(Layout, ClientsStillReadTheImageOfAbi1) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("pose");
  std::filesystem::copy_file(ODOMD_TEST_DATA "/segment_abi_1_0.bin", path);
  ASSERT_EQ(chmod(path.c_str(), 0644), 0);
  const ClientPointer client = open_client(path);
  odom_pose pose{};
  odom_details details{};
  ASSERT_EQ(odom_latest_details(client.get(), &pose, sizeof pose, &details, sizeof details),
            ODOM_STALE);
  EXPECT_EQ(pose.tick, 6U);
  EXPECT_TRUE(is_whole(pose, &details));
  odom_info info{};
  ASSERT_EQ(odom_get_info(client.get(), &info, sizeof info), ODOM_STALE);
  EXPECT_EQ(info.cornering_stiffness_rear, 60.0);
}

}  // namespace
}  // namespace odomd::shm::testing::test_layout
