// The recorder's end of the record socket: what it knows of the end of the connection.
#include "tools/live/recording_feed.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>

#include "tests/tools/scratch.hpp"

namespace odomd::tools::recording_feed_test {
namespace {

FileDescriptor listening_at(const std::string& path) {
  FileDescriptor socket{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  EXPECT_EQ(::bind(socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(::listen(socket.get(), 4), 0);
  return socket;
}

bool runs_at_the_end(RecordingFeed& feed) {
  while (!feed.ended()) EXPECT_FALSE(feed.next(std::chrono::milliseconds(100)).has_value());
  return feed.is_daemon_running();
}

TEST(RecordingFeed, TellsADaemonThatDroppedItFromOneThatHasEnded) {
  const Scratch scratch;
  const std::string path = scratch.path("record.sock").string();
  {
    const FileDescriptor socket = listening_at(path);
    RecordingFeed feed(path);
    { const FileDescriptor dropped{::accept(socket.get(), nullptr, nullptr)}; }
    EXPECT_TRUE(runs_at_the_end(feed));
  }
  const std::string other = scratch.path("other.sock").string();
  const pid_t daemon = ::fork();
  if (daemon == 0) {
    const FileDescriptor socket = listening_at(other);
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
}  // namespace odomd::tools::recording_feed_test
