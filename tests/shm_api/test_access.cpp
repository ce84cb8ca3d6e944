// Whose segments are trusted, which files are refused, and that there is only one writer.
#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>
#include <fstream>
#include <iostream>
#include <random>
#include <tuple>

#include "tests/gtest.hpp"
#include "tests/shm_api/segment_fixture.hpp"

namespace odomd::shm::testing::test_access {
namespace {

constexpr uid_t other_user = 54321;

/// Gives a file to another user, which only root can.
bool give_away(const std::string& file) {
  if (geteuid() != 0) {
    std::cout << "not run: 1 (needs root to give a file to another user)\n";
    return false;
  }
  EXPECT_EQ(chown(file.c_str(), other_user, static_cast<gid_t>(-1)), 0);
  return true;
}

class Access : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string path = directory.file("pose");
  SegmentSettings settings{.name = path, .slots = 8};

  [[nodiscard]] static odom_status try_open(const std::string& name) {
    odom_client* client = nullptr;
    const odom_status status = odom_open(name.c_str(), &client);
    EXPECT_EQ(client != nullptr, status == ODOM_OK);
    odom_close(client);
    return status;
  }

  [[nodiscard]] static std::string refusal(const SegmentSettings& wrong) {
    return message_of([&] { const Writer accepted(wrong, test_info()); });
  }
};

TEST_F(Access, MissingFileIsNoSegment) {
  EXPECT_EQ(try_open(path), ODOM_NO_SEGMENT);
  EXPECT_EQ(try_open(path + "/below"), ODOM_NO_SEGMENT);
}

TEST_F(Access, APosixShmNameIsAFileInDevShm) {
  const std::string name = "/odomd-test-" + std::to_string(getpid());
  {
    const Writer writer({.name = name, .slots = 8}, test_info());
    EXPECT_EQ(try_open(name), ODOM_OK);
    EXPECT_EQ(try_open("/dev/shm" + name), ODOM_OK);
  }
  unlink(("/dev/shm" + name).c_str());
  unlink(("/dev/shm" + name + ".lock").c_str());
}

TEST_F(Access, EnvironmentNamesTheSegmentByDefault) {
  const Writer writer(settings, test_info(1'000'000'000));
  ASSERT_EQ(setenv("ODOM_SHM", path.c_str(), 1), 0);
  odom_client* client = nullptr;
  EXPECT_EQ(odom_open(nullptr, &client), ODOM_OK);
  EXPECT_EQ(info_of(ClientPointer(client)).instance_id, writer.info().instance_id);
  unsetenv("ODOM_SHM");
}

TEST_F(Access, ASegmentOfAnotherUserIsRefused) {
  const Writer writer(settings, test_info());
  ASSERT_EQ(try_open(path), ODOM_OK);
  if (give_away(path)) {
    EXPECT_EQ(try_open(path), ODOM_REFUSED);
  }
}

TEST_F(Access, ASuccessorOfAnotherUserIsNotFollowed) {
  const ClientPointer client = client_of_dead_writer(settings, 1);
  Writer successor(settings, test_info(1'000'000'000));
  publish_patterned(successor, 9, now_ns());
  if (give_away(path)) {
    EXPECT_EQ(latest(client), Latest(ODOM_STALE, 1));
  }
}

TEST_F(Access, ASegmentThatOthersMayWriteIsRefused) {
  const Writer writer(settings, test_info());
  for (const mode_t mode : {0664U, 0646U}) {
    ASSERT_EQ(chmod(path.c_str(), mode), 0);
    EXPECT_EQ(try_open(path), ODOM_REFUSED);
  }
}

TEST_F(Access, LinksPipesAndDirectoriesAreRefused) {
  const Writer writer(settings, test_info());
  const std::string link = directory.file("link");
  const std::string pipe = directory.file("pipe");
  const std::string inner = directory.file("inner");
  ASSERT_EQ(symlink(path.c_str(), link.c_str()), 0);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  ASSERT_EQ(mkdir(inner.c_str(), 0700), 0);
  for (const std::string& name : {link, pipe, inner}) EXPECT_EQ(try_open(name), ODOM_REFUSED);
  EXPECT_EQ(try_open(directory.file(".") + "./"), ODOM_INVALID);
}

TEST_F(Access, AnythingButAWholeSegmentIsAnotherAbi) {
  for (const std::size_t size : {0U, 1U, 4095U, 4096U, 100000U}) {
    std::ofstream(path, std::ios::binary) << std::string(size, 'x');
    EXPECT_EQ(try_open(path), ODOM_ABI) << size;
  }
  std::filesystem::remove(path);
  { const Writer writer(settings, test_info()); }
  ASSERT_EQ(truncate(path.c_str(), 4096 + 8 * 832 - 1), 0);
  EXPECT_EQ(try_open(path), ODOM_ABI);
}

TEST_F(Access, DamagedHeaderIsRefusedOrHarmless) {
  {
    Writer writer(settings, test_info());
    for (std::uint64_t tick = 1; tick < 20; ++tick) publish_patterned(writer, tick, now_ns());
  }
  std::mt19937_64 random(1);
  int accepted = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const std::string damaged = directory.file("damaged");
    std::filesystem::copy_file(path, damaged, std::filesystem::copy_options::overwrite_existing);
    const std::size_t word = trial % 2 == 0 ? random() % 20 : 64 + random() % 8;
    const std::uint64_t value = random() >> (random() % 64);
    std::fstream file(damaged, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(8 * word));
    file.write(reinterpret_cast<const char*>(&value), sizeof value);
    file.close();

    odom_client* client = nullptr;
    if (odom_open(damaged.c_str(), &client) != ODOM_OK) continue;
    ++accepted;
    odom_pose pose{};
    odom_details details{};
    odom_latest_details(client, &pose, sizeof pose, &details, sizeof details);
    odom_at(client, static_cast<std::int64_t>(random()), &pose, sizeof pose);
    pose.tick = 0;
    odom_wait(client, &pose, sizeof pose, 0);
    odom_beat beat{};
    odom_get_beat(client, &beat, sizeof beat);
    odom_close(client);
  }
  EXPECT_GT(accepted, 0);
}

TEST_F(Access, SecondWriterIsRefusedWithThePidOfTheFirst) {
  {
    const Writer writer(settings, test_info());
    EXPECT_THAT(refusal(settings), HasSubstr("process " + std::to_string(getpid()) + " publishes"));
    EXPECT_EQ(try_open(path), ODOM_OK);
  }
  EXPECT_EQ(refusal(settings), "");
}

TEST_F(Access, ALockOfAnotherUserIsRefused) {
  std::ofstream(path + ".lock") << "1\n";
  if (give_away(path + ".lock")) {
    EXPECT_THAT(refusal(settings), HasSubstr("belongs to user 54321"));
  }
}

TEST_F(Access, TheTemporaryFileOfADeadWriterIsRemoved) {
  std::ofstream(path + ".tmp", std::ios::binary) << std::string(1000, '\0');
  const Writer writer(settings, test_info());
  EXPECT_EQ(try_open(path), ODOM_OK);
  EXPECT_FALSE(std::filesystem::exists(path + ".tmp"));
}

TEST_F(Access, OnlyASegmentIsReplaced) {
  const std::string text = directory.file("text");
  const std::string content = "years of work, and no segment";
  std::ofstream(text) << content;
  std::vector<std::string> others{text, directory.file("empty"), directory.file("inner"),
                                  directory.file("link"), directory.file("pipe")};
  std::ofstream(others[1]).flush();
  ASSERT_EQ(mkdir(others[2].c_str(), 0700), 0);
  ASSERT_EQ(symlink(text.c_str(), others[3].c_str()), 0);
  ASSERT_EQ(mkfifo(others[4].c_str(), 0600), 0);
  const std::string device = directory.file("null");
  if (mknod(device.c_str(), S_IFCHR | 0600, makedev(1, 3)) == 0)
    others.push_back(device);
  else
    std::cout << "not run: 1 (needs the right to make a device)\n";
  for (const std::string& other : others) {
    struct stat before {};
    struct stat after {};
    ASSERT_EQ(lstat(other.c_str(), &before), 0);
    EXPECT_THAT(refusal({.name = other}), HasSubstr("not a segment of odomd")) << other;
    ASSERT_EQ(lstat(other.c_str(), &after), 0) << other;
    EXPECT_EQ(after.st_ino, before.st_ino) << other;
    EXPECT_EQ(after.st_mode, before.st_mode) << other;
    EXPECT_FALSE(std::filesystem::exists(other + ".lock")) << other;
  }
  EXPECT_EQ(contents(text), content);
}

TEST_F(Access, OtherFilesUnderTheNamesOfLockAndTemporaryFileAreKept) {
  const std::string lock = path + ".lock";
  // Files as short as a lock, but no locks: a word, a pid file readable by all, more than one line.
  for (const auto& [neighbour, content, mode] :
       {std::tuple{path + ".tmp", "years of work, and not half a segment", 0600U},
        {lock, "years of work, and no lock", 0600U},
        {lock, "sesame\n", 0600U},
        {lock, "1234\n", 0644U},
        {lock, "12\n34\n", 0600U}}) {
    SCOPED_TRACE(neighbour + ": " + content);
    std::ofstream(neighbour) << content;
    ASSERT_EQ(chmod(neighbour.c_str(), mode), 0);
    const std::string kind = neighbour == lock ? "a lock of odomd" : "";
    EXPECT_THAT(refusal({.name = path}), HasSubstr(neighbour + ": is a file, not " + kind));
    EXPECT_EQ(contents(neighbour), content);
    EXPECT_FALSE(std::filesystem::exists(path));
    std::filesystem::remove(neighbour);
  }
  ASSERT_EQ(mkfifo(lock.c_str(), 0600), 0);
  EXPECT_THAT(refusal({.name = path}), HasSubstr(lock + ": is a pipe, not a lock of odomd"));
  std::filesystem::remove(lock);
  EXPECT_EQ(refusal(settings), "");
}

TEST_F(Access, ModeAndGroupAreSet) {
  const gid_t gid = getegid();
  const group* entry = getgrgid(gid);
  ASSERT_NE(entry, nullptr);
  const Writer writer({.name = path, .slots = 8, .mode = 0640, .group = entry->gr_name},
                      test_info());
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777U, 0640U);
  EXPECT_EQ(status.st_gid, gid);
}

TEST_F(Access, InvalidSettingsAreReportedAndKeepThePredecessor) {
  { const Writer writer(settings, test_info()); }
  const std::string before = contents(path);
  const std::pair<SegmentSettings, std::string> cases[]{
      {{.name = "odomd"}, "'odomd'"},
      {{.name = ""}, "[shm] name"},
      {{.name = "/.."}, "[shm] name"},
      {{.name = directory.file("none/pose")}, "no such directory"},
      {{.name = "/" + std::string(300, 'a')}, "too long"},
      {{.name = path, .slots = 1000}, "power of two"},
      {{.name = path, .slots = 2}, "power of two"},
      {{.name = path, .mode = 0666}, "[shm] mode"},
      {{.name = path, .slots = 8, .group = "no-such-group"}, "'no-such-group'"},
  };
  for (const auto& [wrong, message] : cases) EXPECT_THAT(refusal(wrong), HasSubstr(message));
  EXPECT_THROW(Writer({.name = path}, test_info(0)), std::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(path + ".tmp"));
  EXPECT_EQ(contents(path), before);
}

}  // namespace
}  // namespace odomd::shm::testing::test_access
