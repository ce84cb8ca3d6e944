// The layout is a contract with programs that were built years ago: fields and constants are
// pinned, and the segment as a whole is compared with images that ABI 1.0 and 1.1 wrote. Today's
// writer reproduces the newest image, and clients read all images.
#include <sys/stat.h>
#include <cstddef>
#include <cstring>
#include <fstream>

#include "shm_api/layout/slot.h"
#include "tests/gtest.hpp"
#include "tests/shm_api/pinned_layout.h"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_layout {
namespace {

// A change that fails here breaks programs that were built years ago.
TEST(Abi, StructsArePinned) {
#define FIELD(name, offset) EXPECT_EQ(offsetof(Struct, name), std::size_t{offset});
#define STRUCT(name, size, FIELDS)                \
  {                                               \
    using Struct = name;                          \
    EXPECT_EQ(sizeof(Struct), std::size_t{size}); \
    FIELDS(FIELD)                                 \
  }
  PINNED_STRUCTS(STRUCT)
}

// A new value may be appended to an enum (ODOM_SOURCE_COUNT rises); existing values never change.
TEST(Abi, NumbersArePinned) {
#define CONSTANT(name, value) EXPECT_EQ(ODOM_##name, value);
  PINNED_CONSTANTS(CONSTANT)
  PINNED_WORDS(CONSTANT)
}

std::vector<std::uint64_t> words_of(const std::string& path) {
  const std::string bytes = contents(path);
  std::vector<std::uint64_t> words(bytes.size() / 8);
  std::memcpy(words.data(), bytes.data(), 8 * words.size());
  return words;
}

// Identical on every machine, except for the writer's identity and times.
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

std::vector<std::uint64_t> written_words() {
  const TemporaryDirectory directory;
  const std::string path = directory.file("pose");
  write_reference(path);
  return words_of(path);
}

TEST(Layout, TheWriterStillWritesTheNewestImage) {
  std::vector<std::uint64_t> written = written_words();
  std::vector<std::uint64_t> kept = words_of(ODOMD_TEST_DATA "/segment_abi_1_1.bin");
  ASSERT_EQ(written.size(), kept.size());
  for (const std::size_t i : volatile_words) written[i] = kept[i] = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(written[i], kept[i]) << "word " << i;
}

TEST(Layout, TheWriterHasOnlyAppendedToTheImageOfAbi1) {
  std::vector<std::uint64_t> written = written_words();
  std::vector<std::uint64_t> kept = words_of(ODOMD_TEST_DATA "/segment_abi_1_0.bin");
  for (const std::size_t i : volatile_words) written[i] = kept[i] = 0;
  // Values that grow: bytes per slot and of the segment, words of the details, ABI minor version.
  for (const std::size_t i : {2U, 3U, 5U, 8U}) written[i] = kept[i] = 0;
  for (std::size_t i = 0; i < 512; ++i) EXPECT_EQ(written[i], kept[i]) << "word " << i;
  // The words of a slot that ABI 1.0 has: the sequence, 28 of the pose, 61 of the details.
  for (std::size_t slot = 0; slot < 4; ++slot)
    for (std::size_t i = 0; i < 90; ++i)
      EXPECT_EQ(written[512 + 104 * slot + i], kept[512 + 96 * slot + i]) << slot << ", word " << i;
}

void copy_image(const std::string& name, const std::string& path) {
  std::filesystem::copy_file(std::string{ODOMD_TEST_DATA "/"} + name, path);
  ASSERT_EQ(chmod(path.c_str(), 0644), 0);
}

/// The patterned details of a tick, from a daemon that only has the first `words` of them.
odom_details details_of(std::uint64_t tick, std::size_t words) {
  odom_details details{};
  const Record record = patterned(tick, 0);
  std::memcpy(&details, &record.details, 8 * words);
  return details;
}

TEST(Layout, ClientsStillReadEveryImage) {
  for (const auto& [image, words] :
       {std::pair{"segment_abi_1_0.bin", 61U}, std::pair{"segment_abi_1_1.bin", 69U}}) {
    SCOPED_TRACE(image);
    const TemporaryDirectory directory;
    const std::string path = directory.file("pose");
    copy_image(image, path);
    const ClientPointer client = open_client(path);
    odom_pose pose{};
    odom_details details{};
    std::memset(&details, 0x5A, sizeof details);
    ASSERT_EQ(odom_latest_details(client.get(), &pose, sizeof pose, &details, sizeof details),
              ODOM_STALE);
    EXPECT_EQ(pose.tick, 6U);
    EXPECT_TRUE(is_whole(pose));
    const odom_details expected = details_of(6, words);
    EXPECT_EQ(std::memcmp(&details, &expected, sizeof details), 0);
    odom_info info{};
    ASSERT_EQ(odom_get_info(client.get(), &info, sizeof info), ODOM_STALE);
    EXPECT_EQ(info.cornering_stiffness_rear, 60.0);
  }
}

// The image's calibrations are kept; those that the image lacks are "not estimated".
TEST(Layout, AWriterInheritsFromOneOfAbi1) {
  const TemporaryDirectory directory;
  const std::string path = directory.file("pose");
  copy_image("segment_abi_1_0.bin", path);
  // The image has no checksum yet, today's last word of a slot: compute it.
  const std::vector<std::uint64_t> words = words_of(path);
  const std::size_t slot = 512 + 6 % 4 * 96;
  const std::uint64_t checksum = odomi_checksum(words.data() + slot + 1, 28 + 61);
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(8 * (slot + 95)));
  file.write(reinterpret_cast<const char*>(&checksum), sizeof checksum);
  file.close();

  const Writer successor({.name = path, .slots = 4}, test_info());
  ASSERT_TRUE(successor.predecessor().has_value());
  const odom_details expected = details_of(6, 61);
  const odom_details& inherited = successor.predecessor()->details;
  EXPECT_EQ(std::memcmp(&inherited, &expected, sizeof expected), 0);
  EXPECT_EQ(inherited.further_calibration_sigma[3], 0.0);
}

}  // namespace
}  // namespace odomd::shm::testing::test_layout
