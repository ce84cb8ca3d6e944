// The log: its file, repeats, events from the beat, standard error.
#include "daemon/journal/journal.hpp"

#include <fcntl.h>
#include <spdlog/logger.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <climits>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>

#include "base/file_descriptor.hpp"
#include "daemon/journal/error_sink.hpp"
#include "daemon/journal/event.hpp"
#include "daemon/journal/repeats.hpp"
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

TEST_F(JournalTest, FiltersByLevelAndCountsRepeatedEvents) {
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

TEST_F(JournalTest, KeepsTheOldFileIfReopeningFails) {
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

TEST_F(JournalTest, ReportsOnceOnStandardErrorThatItsFileIsFull) {
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

class ErrorSinkTest : public testing::Test {
 protected:
  void SetUp() override {
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    out_ = FileDescriptor(ends[0]);
    in_ = FileDescriptor(ends[1]);
    ASSERT_EQ(fcntl(out_.get(), F_SETFL, O_NONBLOCK), 0);
    auto sink = std::make_shared<ErrorSink>(in_.get());
    sink->set_pattern("%v");
    logger_ = std::make_unique<spdlog::logger>("test", sink);
  }

  void fill_pipe() const {
    ASSERT_EQ(fcntl(in_.get(), F_SETFL, O_NONBLOCK), 0);
    const std::string page(PIPE_BUF, 'x');
    while (write(in_.get(), page.data(), page.size()) > 0) {
    }
    ASSERT_EQ(fcntl(in_.get(), F_SETFL, 0), 0);
  }

  [[nodiscard]] std::string read_all() const {
    std::string text;
    std::array<char, 4096> part{};
    for (ssize_t size = 0; (size = read(out_.get(), part.data(), part.size())) > 0;)
      text.append(part.data(), static_cast<std::size_t>(size));
    return text;
  }

  FileDescriptor out_;
  FileDescriptor in_;
  std::unique_ptr<spdlog::logger> logger_;
};

TEST_F(ErrorSinkTest, DoesNotWaitForASlowReaderAndReportsLostLines) {
  fill_pipe();
  logger_->info("one");
  logger_->info("two");
  EXPECT_THAT(read_all(), Not(HasSubstr("one")));
  logger_->info("three");
  logger_->info("four");
  EXPECT_EQ(read_all(), "(2 lines lost: standard error was not read)\nthree\nfour\n");
}

TEST_F(ErrorSinkTest, TruncatesALineThatMightNotFit) {
  logger_->info(std::string(std::size_t{100'000}, 'y'));
  const auto text = read_all();
  EXPECT_EQ(text.size(), std::size_t{PIPE_BUF});
  EXPECT_EQ(text.back(), '\n');
}

TEST(EventRing, KeepsTheOrderAndCountsDroppedEvents) {
  const auto ring = std::make_unique<EventRing>();
  constexpr std::int64_t pushed = 1000;
  for (std::int64_t i = 0; i < pushed; ++i) ring->push({EventKind::missed, i, -i});
  std::int64_t read = 0;
  for (; const auto event = ring->next(); ++read) {
    EXPECT_EQ(event->kind, EventKind::missed);
    EXPECT_EQ(event->a, read);
    EXPECT_EQ(event->b, -read);
  }
  EXPECT_EQ(read + static_cast<std::int64_t>(ring->dropped()), pushed);
  EXPECT_GT(ring->dropped(), 0U);
}

Message warning(const std::string& text) {
  return {spdlog::level::warn, text};
}

std::vector<std::string> texts(const std::vector<Message>& messages) {
  std::vector<std::string> texts;
  for (const auto& message : messages) texts.push_back(message.text);
  return texts;
}

/// The times [s] of log lines for a message that comes every `every` seconds, until `length`.
std::vector<std::int64_t> logged(Repeats& repeats, std::int64_t every, std::int64_t length) {
  std::vector<std::int64_t> times;
  for (std::int64_t t = 0; t <= length; ++t) {
    if (!repeats.due(t * second).empty()) times.push_back(t);
    if (t % every == 0 && repeats.take(warning("ticks missed: " + std::to_string(t)), t * second))
      times.push_back(t);
  }
  return times;
}

TEST(Repeats, IntervalsGrowFromASecondToTenMinutes) {
  Repeats often, seldom;
  EXPECT_THAT(logged(often, 1, 2600), ElementsAre(0, 1, 5, 21, 85, 341, 941, 1541, 2141));
  EXPECT_THAT(logged(seldom, 15, 600), ElementsAre(0, 15, 30, 46, 110, 366));
}

TEST(Repeats, SummaryHasTheNewestTextTheCountAndTheDuration) {
  Repeats repeats;
  EXPECT_TRUE(repeats.take(warning("ticks missed: 1"), 0));
  EXPECT_FALSE(repeats.take(warning("ticks missed: 2"), second / 4));
  EXPECT_FALSE(repeats.take({spdlog::level::info, "ticks missed: 7"}, second / 2));
  EXPECT_THAT(repeats.due(second - 1), IsEmpty());
  const auto due = repeats.due(3 * second);
  ASSERT_THAT(texts(due), ElementsAre("ticks missed: 7 (2 times in 3 s, the last 2.5 s ago)"));
  EXPECT_EQ(due.front().level, spdlog::level::info);
  EXPECT_THAT(repeats.due(600 * second), IsEmpty());
}

TEST(Repeats, MessageIsNewAgainAfterTenQuietMinutes) {
  Repeats repeats;
  EXPECT_TRUE(repeats.take(warning("down"), 0));
  EXPECT_TRUE(repeats.take(warning("down"), 2 * second));
  EXPECT_THAT(repeats.due(602 * second), IsEmpty());
  EXPECT_TRUE(repeats.take(warning("down"), 603 * second));
  EXPECT_FALSE(repeats.take(warning("down"), 603 * second));
  EXPECT_THAT(texts(repeats.due(604 * second)), ElementsAre(HasSubstr("(1 time in 1 s")));
}

TEST(Repeats, DistinguishesMessagesBySubjectNotByNumbers) {
  Repeats repeats;
  for (const auto& [text, is_new] :
       std::vector<std::pair<std::string, bool>>{{"can0: lost 3 frames", true},
                                                 {"can1: lost 3 frames", true},
                                                 {"1.log: lost 3 frames", true},
                                                 {"2.log: lost 3 frames", true},
                                                 {"can0: lost 17 frames", false},
                                                 {"connected (pid 7, uid 0)", true},
                                                 {"connected (pid 81, uid 1000)", false},
                                                 {"stepped by +0.500000 s", true},
                                                 {"stepped by -1.2e-05 s", false}})
    EXPECT_EQ(repeats.take(warning(text), 0), is_new) << text;
}

TEST(Repeats, ReportsAllCountedMessagesAtTheEnd) {
  Repeats repeats;
  for (const char* text : {"a", "b", "b", "c", "c", "c"})
    static_cast<void>(repeats.take(warning(text), 0));
  EXPECT_THAT(texts(repeats.rest(second / 2)),
              ElementsAre("b (1 time in 0.5 s)", "c (2 times in 0.5 s)"));
  EXPECT_THAT(repeats.rest(second), IsEmpty());
}

}  // namespace
}  // namespace odomd::daemon::journal_test
