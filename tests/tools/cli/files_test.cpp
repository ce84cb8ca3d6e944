// Output files that are complete or absent: the files that they replace, and other writers.
#include "tools/cli/files.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::files_test {
namespace {

struct stat status_of(const std::filesystem::path& file) {
  struct stat status {};
  EXPECT_EQ(::stat(file.c_str(), &status), 0) << file;
  return status;
}

std::ptrdiff_t count_of(const std::filesystem::path& folder) {
  const std::filesystem::directory_iterator entries(folder);
  return std::distance(begin(entries), end(entries));
}

TEST(WholeFile, KeepsTheLinkTheModeAndTheOwnerOfTheFileItReplaces) {
  const Scratch scratch;
  const auto target = scratch.write("target", "old");
  for (const mode_t mode : {0400U, 0604U, 0660U}) {
    ASSERT_EQ(::chmod(target.c_str(), mode), 0);
    // Only root can give a file away.
    const uid_t owner = ::geteuid() == 0 ? 65534 : ::geteuid();
    ASSERT_EQ(::chown(target.c_str(), owner, static_cast<gid_t>(-1)), 0);
    const auto link = scratch.path("link");
    std::filesystem::remove(link);
    std::filesystem::create_symlink("target", link);
    write_whole(link, fmt::format("new {}", mode));
    EXPECT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_EQ(contents(target), fmt::format("new {}", mode));
    EXPECT_EQ(status_of(target).st_mode & 07777U, mode);
    EXPECT_EQ(status_of(target).st_uid, owner);
    EXPECT_EQ(count_of(scratch.path("")), 2);
  }
}

TEST(WholeFile, WritersOfOneFileDoNotDisturbEachOther) {
  const Scratch scratch;
  const auto file = scratch.write("file", "old");
  {
    WholeFile first(file), second(file), third(file);
    first.stream() << "first, and longer";
    second.stream() << "second";
    third.stream() << "never finished";
    check_writable(file);
    EXPECT_EQ(contents(file), "old");
    second.finish();
    EXPECT_EQ(contents(file), "second");
    first.finish();
  }
  EXPECT_EQ(contents(file), "first, and longer");
  EXPECT_EQ(count_of(scratch.path("")), 1);
}

// Whoever may write to the folder could otherwise make root overwrite any file.
TEST(WholeFile, DoesNotWriteThroughALinkAtTheNameOfItsCopy) {
  const Scratch scratch;
  const auto file = scratch.write("file", "old");
  const auto secret = scratch.write("secret", "precious");
  ASSERT_EQ(::chmod(secret.c_str(), 0600), 0);
  for (int i = 0; i < 3; ++i)
    std::filesystem::create_symlink("secret",
                                    scratch.path(fmt::format("file.{}-{}.partial", ::getpid(), i)));
  write_whole(file, "new");
  EXPECT_EQ(contents(file), "new");
  EXPECT_EQ(contents(secret), "precious");
  EXPECT_EQ(status_of(secret).st_mode & 07777U, 0600U);
}

}  // namespace
}  // namespace odomd::tools::files_test
