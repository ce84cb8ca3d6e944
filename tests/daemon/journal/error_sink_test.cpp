#include "daemon/journal/error_sink.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <climits>
#include <memory>
#include <string>

#include <spdlog/logger.h>

#include "base/file_descriptor.hpp"

namespace odomd::daemon::error_sink_test {
namespace {

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

TEST_F(ErrorSinkTest, WritesLines) {
  logger_->info("one");
  logger_->info("two");
  EXPECT_EQ(read_all(), "one\ntwo\n");
}

TEST_F(ErrorSinkTest, DoesNotWaitForASlowReaderAndReportsLostLines) {
  fill_pipe();
  logger_->info("one");
  logger_->info("two");
  EXPECT_THAT(read_all(), testing::Not(testing::HasSubstr("one")));
  logger_->info("three");
  logger_->info("four");
  EXPECT_EQ(read_all(), "(2 lines lost: standard error was not read)\nthree\nfour\n");
}

TEST_F(ErrorSinkTest, CutsALineThatMightNotFit) {
  logger_->info(std::string(std::size_t{100'000}, 'y'));
  const auto text = read_all();
  EXPECT_EQ(text.size(), std::size_t{PIPE_BUF});
  EXPECT_EQ(text.back(), '\n');
}

}  // namespace
}  // namespace odomd::daemon::error_sink_test
