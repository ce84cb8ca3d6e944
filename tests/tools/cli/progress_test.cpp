// The progress of long work, on a terminal and elsewhere.
#include "tools/cli/progress.hpp"

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>

#include "base/file_descriptor.hpp"

namespace odomd::tools::progress_test {
namespace {

// What comes out of a terminal that a child shows two states on.
std::string on_a_terminal(unsigned short columns = 80) {
  int master = -1;
  const winsize size{.ws_row = 24, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
  const pid_t pid = ::forkpty(&master, nullptr, nullptr, &size);
  if (pid == 0) {
    {
      ProgressLine progress("odom test", WithoutTerminal::nothing);
      progress.show("half done");
      progress.show("at once after it, and so left out");
    }
    ::_exit(0);
  }
  const FileDescriptor terminal{master};
  std::string seen;
  char byte = 0;
  while (::read(terminal.get(), &byte, 1) == 1) seen += byte;
  ::waitpid(pid, nullptr, 0);
  return seen;
}

TEST(ProgressLine, IsRewrittenOnATerminalAndEndsWithALineBreak) {
  EXPECT_EQ(on_a_terminal(), "\rhalf done\x1b[K\r\n");
}

TEST(ProgressLine, IsCutToTheTerminalBecauseAWrappedLineCannotBeRewritten) {
  EXPECT_EQ(on_a_terminal(6), "\rhalf…\x1b[K\r\n");
}

TEST(ProgressLine, OfQuickWorkIsNotPrintedElsewhere) {
  ::testing::internal::CaptureStderr();
  {
    ProgressLine progress("odom test");
    progress.show("half done");
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace odomd::tools::progress_test
