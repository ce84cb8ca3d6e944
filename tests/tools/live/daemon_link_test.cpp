// How the tools find a daemon, and what a recorder knows of the end of its connection.
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/live/own_daemon.hpp"
#include "tests/tools/scratch.hpp"
#include "tools/live/daemon_link.hpp"
#include "tools/live/recording_feed.hpp"

namespace odomd::tools::daemon_link_test {
namespace {

using ::testing::HasSubstr;

std::string problem_of(const std::string& leaf) {
  try {
    return "found: " + socket_path({}, leaf);
  } catch (const NobodyThere& error) {
    return error.what();
  }
}

TEST(SocketPath, ANamedOneIsTakenWhetherItIsThereOrNot) {
  EXPECT_EQ(socket_path("nowhere.sock", "status.sock"), "nowhere.sock");
}

TEST(SocketPath, AnErrorNamesAllPlaces) {
  ASSERT_EQ(::setenv("XDG_RUNTIME_DIR", "/run/user/4711", 1), 0);
  EXPECT_THAT(problem_of("none.sock"),
              HasSubstr("/run/user/4711/odomd/none.sock, /run/odomd/*/none.sock, "
                        "/run/odomd/none.sock: no such socket; is odomd running?"));
  ASSERT_EQ(::unsetenv("XDG_RUNTIME_DIR"), 0);
  EXPECT_THAT(problem_of("none.sock"), HasSubstr("$XDG_RUNTIME_DIR (not set), /run/odomd/*/"));
}

TEST(SocketPath, TheStatusIsThatOfTheUsersOwnDaemon) {
  const Scratch runtime;
  std::filesystem::create_directory(runtime.path("odomd"));
  const AnsweringSocket daemon{runtime.path("odomd/status.sock").string(), R"({"pid": 4711})"};
  const Outcome outcome =
      run_shell("XDG_RUNTIME_DIR=" + runtime.path("").string() + " odom status --json");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("4711"));
}

TEST(SocketPath, RecordAndCameraSendLookInTheSamePlaces) {
  const Scratch runtime;
  std::filesystem::create_directory(runtime.path("odomd"));
  const std::string own = runtime.path("").string();
  const std::string with = "XDG_RUNTIME_DIR=" + own;
  const AnsweringSocket recorder{runtime.path("odomd/record.sock").string(), "no recording"};
  EXPECT_THAT(run_shell(with + " odom record").err, HasSubstr(own + "/odomd/record.sock: "));
  const AnsweringSocket camera{runtime.path("odomd/camera.sock").string(), "no camera"};
  EXPECT_THAT(run_shell(with + " odom camera send --pose 1,2,3").err,
              HasSubstr(own + "/odomd/camera.sock: "));
}

bool runs_at_the_end(RecordingFeed& feed) {
  while (!feed.ended()) EXPECT_FALSE(feed.next(std::chrono::milliseconds(100)).has_value());
  return feed.is_daemon_running();
}

TEST(RecordingFeed, TellsADaemonThatDroppedItFromOneThatHasEnded) {
  const Scratch scratch;
  const std::string path = scratch.path("record.sock").string();
  {
    const FileDescriptor socket = listening_socket(path, SOCK_STREAM);
    RecordingFeed feed(path);
    { const FileDescriptor dropped{::accept(socket.get(), nullptr, nullptr)}; }
    EXPECT_TRUE(runs_at_the_end(feed));
  }
  const std::string other = scratch.path("other.sock").string();
  const pid_t daemon = ::fork();
  if (daemon == 0) {
    const FileDescriptor socket = listening_socket(other, SOCK_STREAM);
    for (;;) ::pause();
  }
  while (!std::filesystem::exists(other)) ::usleep(1000);
  ::usleep(20'000);  // it listens
  RecordingFeed feed(other);
  ::kill(daemon, SIGKILL);
  EXPECT_FALSE(runs_at_the_end(feed)) << "a zombie does not run";
  ::waitpid(daemon, nullptr, 0);
}

}  // namespace
}  // namespace odomd::tools::daemon_link_test
