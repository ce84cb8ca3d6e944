#include "daemon/journal/journal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace odomd::daemon::journal_test {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr std::int64_t second = 1'000'000'000;

class JournalTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "odomd_journal_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    directory_ = name;
    file_ = directory_ / "odomd.log";
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  static std::string content(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }

  std::filesystem::path directory_;
  std::filesystem::path file_;
};

TEST_F(JournalTest, WritesFromItsLevelOn) {
  Journal journal({file_, "warn"});
  journal.info("quiet");
  journal.warn("loud");
  EXPECT_THAT(content(file_), HasSubstr("warning: loud"));
  EXPECT_THAT(content(file_), Not(HasSubstr("quiet")));
}

TEST_F(JournalTest, SaysOneSentenceASecondOnATopic) {
  Journal journal({file_, "info"});
  for (int i = 0; i < 10; ++i) journal.warn(Topic::overrun, i, "first flood");
  journal.warn(Topic::missed, 5, "another topic");
  journal.warn(Topic::overrun, second, "second flood");
  const auto text = content(file_);
  EXPECT_EQ(text.find("first flood"), text.rfind("first flood"));
  EXPECT_THAT(text, HasSubstr("another topic"));
  EXPECT_THAT(text, HasSubstr("second flood (9 more like this since the last one)"));
}

TEST_F(JournalTest, OpensItsFileAnew) {
  Journal journal({file_, "info"});
  journal.info("before");
  const auto moved = directory_ / "odomd.log.1";
  std::filesystem::rename(file_, moved);
  journal.info("still into the old one");
  journal.reopen();
  journal.info("after");
  EXPECT_THAT(content(moved), HasSubstr("still into the old one"));
  EXPECT_THAT(content(moved), Not(HasSubstr("after")));
  EXPECT_THAT(content(file_), HasSubstr("after"));
}

TEST_F(JournalTest, KeepsTheOldFileWhereTheNewOneCannotBeMade) {
  const auto inner = directory_ / "logs";
  std::filesystem::create_directory(inner);
  Journal journal({inner / "odomd.log", "info"});
  const auto moved = directory_ / "moved";
  std::filesystem::rename(inner, moved);
  std::ofstream(inner) << "in the way";
  journal.reopen();
  EXPECT_THAT(content(moved / "odomd.log"), HasSubstr("keeping the old one"));
}

TEST_F(JournalTest, RefusesAFileThatCannotBeOpened) {
  EXPECT_THROW(Journal({directory_, "info"}), std::invalid_argument);
}

}  // namespace
}  // namespace odomd::daemon::journal_test
