#include "daemon/journal/journal.hpp"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/tools/scratch.hpp"

namespace odomd::daemon::journal_test {
namespace {

constexpr std::int64_t second = 1'000'000'000;

class JournalTest : public testing::Test {
 protected:
  [[nodiscard]] long lines_with(std::string_view text) const {
    std::ifstream log(file_);
    long count = 0;
    for (std::string line; std::getline(log, line);)
      count += line.find(text) != std::string::npos ? 1 : 0;
    return count;
  }

  const tools::Scratch scratch_;
  const std::filesystem::path directory_ = scratch_.path("");
  const std::filesystem::path file_ = scratch_.path("odomd.log");
};

TEST_F(JournalTest, LogsFromItsLevelOnAndARepeatedEventOnceAndThenItsNumber) {
  {
    Journal journal({file_, "warn"});
    journal.turn(0);
    journal.info("quiet");
    for (int i = 0; i < 10; ++i) journal.warn_counted("flood " + std::to_string(i));
    journal.info_counted("quiet");
    EXPECT_EQ(lines_with("warning: flood 0"), 1);
    journal.turn(second / 2);
    EXPECT_EQ(lines_with(""), 1);
    journal.turn(second);
    EXPECT_EQ(lines_with("warning: flood 9 (9 times in 1 s"), 1);
    EXPECT_EQ(lines_with(""), 2);
    journal.warn_counted("flood 10");
  }
  EXPECT_EQ(lines_with("flood 10 (1 time in "), 1) << "the rest, at its end";
}

// The last line about a state must report the current state.
TEST_F(JournalTest, LogsEveryChangeOfAStateAtOnce) {
  Journal journal({file_, "info"});
  for (int flap = 0; flap < 8; ++flap) {
    journal.turn(flap * second);
    journal.info("can0: the bus is up again");
    journal.warn("can0: the bus is down");
  }
  EXPECT_EQ(lines_with("is down"), 8);
}

TEST_F(JournalTest, KeepsTheOldFileWhereTheNewOneCannotBeMade) {
  const auto inner = directory_ / "logs", moved = directory_ / "moved";
  std::filesystem::create_directory(inner);
  Journal journal({inner / "odomd.log", "info"});
  std::filesystem::rename(inner, moved);
  std::ofstream(inner) << "in the way";
  journal.reopen();
  EXPECT_THAT(tools::contents(moved / "odomd.log"), HasSubstr("keeping the old one"));
  std::filesystem::remove(inner);
  std::filesystem::create_directory(inner);
  ASSERT_EQ(::mkfifo((inner / "odomd.log").c_str(), 0600), 0);
  journal.reopen();
  EXPECT_THAT(tools::contents(moved / "odomd.log"),
              HasSubstr("keeping the old one: is a named pipe"));
}

TEST_F(JournalTest, RefusesAFileThatCannotBeOpened) {
  EXPECT_THROW(Journal({directory_, "info"}), std::invalid_argument);
  EXPECT_THROW(Journal({"/dev/null", "info"}), std::invalid_argument);
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
  EXPECT_THROW(Journal({file_, "info"}), std::invalid_argument) << "it would wait for a reader";
}

TEST_F(JournalTest, SaysOnceOnStandardErrorThatItsFileIsFull) {
  Journal journal({file_, "info"});
  journal.turn(0);
  std::filesystem::resize_file(file_, 1 << 20);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit smaller{1 << 19, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  testing::internal::CaptureStderr();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &smaller), 0);
  for (int i = 0; i < 5; ++i) journal.info("lost");
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  static_cast<void>(std::signal(SIGXFSZ, handler));
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr(" odomd error: " + file_.string() + ": messages are lost: "));
  EXPECT_EQ(said.find('\n'), said.size() - 1) << said;
  journal.turn(second);
  EXPECT_THAT(tools::contents(file_), HasSubstr("messages are lost"));
}

}  // namespace
}  // namespace odomd::daemon::journal_test
